// A headless Chromium that a test drives by the WebDriver protocol (chromedriver).
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

namespace firn::cli {

class Browser {
 public:
  // Throws std::runtime_error when chromedriver or Chromium cannot be started.
  Browser();
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void open(const std::string& url);
  // The value of a JavaScript expression in the page.
  nlohmann::json value(const std::string& expression);
  // Whether the expression becomes true within the time.
  bool becomes(const std::string& expression,
               std::chrono::milliseconds within = std::chrono::seconds(30));
  void resize(int width, int height);
  // Presses keys on the element that has the focus.
  void press(const std::string& keys);
  // Errors that the pages have put on the console so far, one a line.
  std::string console_errors();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn::cli
