// Machine parts as kinds of [[boundaries]].
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "experiments/machine/swept_solid.h"
#include "experiments/text/toml_document.h"

namespace firn {

// The kinds that read_machine_part() supports.
std::span<const std::string_view> machine_kinds();

// Reads a part from the keys of its kind. `common`: keys of all boundaries, which the caller reads.
// Throws InputError with file, line and key.
Solid read_machine_part(const TomlTable& table, std::string_view kind,
                        std::span<const std::string_view> common);

}  // namespace firn
