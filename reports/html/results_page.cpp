#include "reports/html/results_page.h"

#include <fmt/format.h>

#include "firn/math.h"

namespace firn {

page::Page page_from(const std::string& file, const std::function<page::Page()>& build) {
  const auto refusal = [&](const std::exception& e) {
    return InputError(
        fmt::format("{}: a page cannot be made of it: {}; expected results.json as Firn writes it",
                    file, e.what()));
  };
  try {
    return build();
  } catch (const BadValue& e) {
    throw refusal(e);
  } catch (const std::logic_error& e) {  // of a plot
    throw refusal(e);
  }
}

}  // namespace firn
