// The document of a page after its scripts have run, from headless Chromium. For pages without
// interaction; tests/app/pages/browser.h drives a browser by the WebDriver protocol.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

namespace firn {

inline std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> part{};
  for (std::size_t n = 0; pipe && (n = fread(part.data(), 1, part.size(), pipe)) > 0;)
    text.append(part.data(), n);
  if (pipe) pclose(pipe);
  return text;
}

inline bool has_browser() { return !output_of("command -v chromium").empty(); }

// The document 10 s of virtual time after it was opened. Fails the test if the page wrote to the
// console.
inline std::string document_of(const std::filesystem::path& page, const std::string& hash = "",
                               const std::string& window = "800,600") {
  const std::string folder = page.parent_path().string(), log = folder + "/log";
  const std::string dom = output_of(
      "timeout 120 chromium --headless --no-sandbox --use-angle=swiftshader "
      "--enable-unsafe-swiftshader --enable-logging=stderr --virtual-time-budget=10000 "
      "--window-size=" +
      window + " --user-data-dir='" + folder + "/profile' --dump-dom 'file://" + page.string() +
      hash + "' 2>'" + log + "'");
  EXPECT_FALSE(dom.empty()) << output_of("tail -n 3 '" + log + "'");
  EXPECT_EQ(output_of("grep -E 'CONSOLE' '" + log + "' | head -n 5 | cut -c1-300"), "");
  return dom;
}

// An element of the document by its id, without the scripts that may hold the same words.
inline std::string element(const std::string& dom, const std::string& id) {
  const std::size_t at = dom.find(" id=\"" + id + "\"");
  EXPECT_NE(at, std::string::npos) << id;
  return at == std::string::npos ? "" : dom.substr(at, 16'000);
}

}  // namespace firn
