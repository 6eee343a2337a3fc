// Whether a page fits a phone of 400 px, in JavaScript that runs in the page.
#pragma once

namespace firn::test {

inline constexpr const char* set_phone_width = "document.documentElement.style.width = '400px'";

// The elements that reach beyond the screen and that no parent scrolls or cuts.
inline constexpr const char* outside_of_phone =
    R"([...document.querySelectorAll('body *')].filter((e) => {
    for (let p = e.parentElement; p; p = p.parentElement)
      if (['auto', 'hidden', 'scroll'].includes(getComputedStyle(p).overflowX)) return false;
    return e.getBoundingClientRect().right > 401;
  }))";

}  // namespace firn::test
