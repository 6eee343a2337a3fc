#include "reports/html/assets.h"

#include <stdexcept>
#include <string>

namespace firn {

std::string_view asset(std::string_view name) {
  for (const auto& [known, text] : embedded_assets())
    if (known == name) return text;
  throw std::logic_error("no asset " + std::string(name));
}

}  // namespace firn
