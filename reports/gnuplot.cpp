#include "reports/gnuplot.h"

#include <fmt/core.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "solver/types.h"

namespace firn {
namespace {

// As one word of the shell's language.
std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

}  // namespace

Gnuplot::Gnuplot() {
  std::string name = (std::filesystem::temp_directory_path() / "firn-gnuplot-XXXXXX").string();
  if (!mkdtemp(name.data())) throw RunError(fmt::format("{}: no such folder can be made", name));
  folder_ = name;
}

Gnuplot::~Gnuplot() {
  std::error_code ignored;  // a folder left behind in the temporary one harms nobody
  std::filesystem::remove_all(folder_, ignored);
}

std::string Gnuplot::image(const std::string& name, const Image& image) const {
  const std::filesystem::path file = data_file(name);
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(image.pixels.data()),
               static_cast<std::streamsize>(3 * image.pixels.size()));
  stream.close();
  if (!stream) throw RunError(fmt::format("{}: cannot be written", file.string()));
  return fmt::format("{} binary array=({},{}) format='%uchar%uchar%uchar'", quoted(file.string()),
                     image.width, image.height);
}

void Gnuplot::run(const std::string& script) const {
  const std::filesystem::path file = data_file("script.gp");
  std::ofstream stream(file);
  stream << script;
  stream.close();
  if (!stream) throw RunError(fmt::format("{}: cannot be written", file.string()));

  const std::string command = "gnuplot " + shell_word(file.string()) + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw RunError("gnuplot cannot be started");
  std::string messages;
  std::array<char, 512> buffer;
  while (fgets(buffer.data(), buffer.size(), pipe)) messages += buffer.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    throw InputError(
        "pictures need the program gnuplot, which is not installed; expected it on "
        "the PATH (Debian: gnuplot-nox)");
  }
  if (status == 0) return;
  // The last line that says something is the reason.
  while (!messages.empty() && messages.back() == '\n') messages.pop_back();
  const auto line = messages.find_last_of('\n');
  throw RunError("gnuplot: " + (line == std::string::npos ? messages : messages.substr(line + 1)));
}

std::string Gnuplot::quoted(const std::string& text) {
  std::string result = "'";
  for (char c : text) result += c == '\'' ? "''" : std::string(1, c);
  return result + "'";
}

std::string Gnuplot::output(const std::string& file, int width, int height) {
  const std::string extension = std::filesystem::path(file).extension().string();
  std::string terminal;
  if (extension == ".png") {
    terminal = fmt::format("pngcairo size {},{} font 'DejaVu Sans,13' rounded", width, height);
  } else if (extension == ".svg") {
    terminal = fmt::format("svg size {},{} font 'DejaVu Sans,13' rounded background 'white'", width,
                           height);
  } else {
    throw InputError(fmt::format("{}: no format of pictures; expected FILE.png or FILE.svg", file));
  }
  return fmt::format("set terminal {}\nset output {}\n", terminal, quoted(file));
}

}  // namespace firn
