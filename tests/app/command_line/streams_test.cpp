// Standard output and standard error: their order in one file, and progress on a terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>

#include "tests/app/program.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;

// More than one buffer of standard output.
std::string case_with_many_walls() {
  std::string text = two_boxes;
  for (int i = 0; i < 40; ++i)
    text += "[[boundaries]]\nname = \"wall " + std::to_string(i) +
            "\"\nmaterial = \"plastic\"\nkind = \"box\"\nsize = \"10 10 10 mm\"\nposition = \"" +
            std::to_string(100 + 20 * i) + " 0 5 mm\"\n";
  return text;
}

TEST(Streams, AreInOrderInOneFile) {
  const Folder folder;
  folder.write("case.toml", case_with_many_walls());
  const std::vector<std::string> command = {"shape", "case.toml", "--picture", "scene.svg"};
  const Outcome apart = folder.firn(command);
  ASSERT_EQ(apart.status, 0) << apart.err;
  ASSERT_GT(apart.out.size(), 8192U);
  ASSERT_THAT(apart.err, HasSubstr("drawn in scene.svg\n"));
  const Outcome together = folder.wait(folder.start(command, [] { dup2(1, 2); }));
  EXPECT_EQ(together.out, apart.out + apart.err);
}

// What a command writes to a terminal of that width, at standard error.
std::string on_terminal(const Folder& folder, const std::vector<std::string>& command,
                        unsigned short columns) {
  int master = -1, slave = -1;
  const winsize size = {24, columns, 0, 0};
  EXPECT_EQ(openpty(&master, &slave, nullptr, nullptr, &size), 0);
  const pid_t pid = folder.start(command, [&] {
    dup2(slave, 2);
    close(master);
  });
  close(slave);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n; (n = read(master, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  close(master);
  EXPECT_EQ(folder.wait(pid).status, 0) << text;
  return text;
}

std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

TEST(Streams, TheProgressLineFitsTheTerminal) {
  const Folder folder;
  folder.write("case.toml", std::string(two_boxes) +
                                "[[stages]]\nname = \"stage of a long name: Eiswürfel fallen auf "
                                "eine Platte und liegen dann übereinander\"\n"
                                "max_duration = \"50 ms\"\n");
  for (const unsigned short columns : {20, 40, 80, 200}) {
    const std::string text =
        on_terminal(folder, {"run", "case.toml", "-o", "a.h5", "--json"}, columns);
    const std::string erase = "\r\x1b[K";
    std::size_t bars = 0, longest = 0;
    for (std::size_t at = 0; (at = text.find(erase, at)) != text.npos;) {
      at += erase.size();
      const std::string line =
          text.substr(at, std::min(text.find_first_of("\r\n", at), text.size()) - at);
      if (!line.starts_with("[")) continue;
      ++bars;
      longest = std::max(longest, characters(line));
    }
    EXPECT_GT(bars, 0U) << text;
    EXPECT_LT(longest, columns) << text;
    if (columns < 200) {
      EXPECT_EQ(longest, columns - 1U) << "cut too early";
    }
  }
}

}  // namespace
}  // namespace firn::cli
