#include "reports/html/pdf_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>

#include "experiments/system/input_file.h"
#include "experiments/system/output_file.h"
#include "experiments/system/process.h"
#include "experiments/system/temporary_folder.h"
#include "firn/math.h"

namespace firn {
namespace {

constexpr int kNotFound = 127;
constexpr std::array kBrowsers = {"chromium", "chromium-browser", "google-chrome",
                                  "google-chrome-stable"};

bool is_whole_pdf(const std::string& bytes) {
  const std::size_t end = bytes.rfind("%%EOF");
  return bytes.starts_with("%PDF-") && end != bytes.npos && bytes.size() - end <= 8;
}

}  // namespace

void write_pdf(const page::Page& page, const std::string& file) {
  const TemporaryFolder folder("pdf");
  const std::string html = folder.file("page.html"), pdf = folder.file("page.pdf");
  page.write(html);
  std::vector<std::string> arguments = {"",
                                        "--headless",
                                        "--disable-gpu",
                                        "--disable-extensions",
                                        "--no-first-run",
                                        "--no-pdf-header-footer",
                                        "--print-to-pdf-no-header",  // its name in older versions
                                        "--virtual-time-budget=5000",
                                        "--user-data-dir=" + folder.file("profile"),
                                        "--print-to-pdf=" + pdf,
                                        "file://" + html};
  if (geteuid() == 0) arguments.insert(arguments.begin() + 1, "--no-sandbox");  // or it refuses
  ProcessLimits limits;
  limits.processor_time = 120;
  for (const char* browser : kBrowsers) {
    arguments.front() = browser;
    const CommandResult result = run_repeatable_command(arguments, folder.path().string(), limits);
    if (result.status == kNotFound) continue;
    const std::string bytes = read_own_file(pdf);
    if (result.status != 0 || !is_whole_pdf(bytes))
      throw RunError(fmt::format("{}: printed no whole PDF (status {}): {}", browser, result.status,
                                 failure_text(result)));
    write_file(file, bytes);
    return;
  }
  throw InputError(fmt::format(
      "{}: a PDF needs the program chromium, which is not installed; expected it on the PATH "
      "(Debian: chromium), or FILE.html",
      file));
}

}  // namespace firn
