// Pages of results.json files.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include "reports/html/page.h"

namespace firn {

// Values of a file that do not fit each other, such as lists of different lengths.
struct BadValue : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Result of `build` for the document of a file. A BadValue, or a plot of lists of different
// lengths, becomes an InputError that names the file.
page::Page page_from(const std::string& file, const std::function<page::Page()>& build);

}  // namespace firn
