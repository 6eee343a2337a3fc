// What every reader of a results file promises: it refuses with one line, or its results are
// finite.
#pragma once

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <regex>
#include <stdexcept>
#include <string>

#include "experiments/case_reader/read_case.h"
#include "experiments/export/export.h"
#include "experiments/responses/measure.h"
#include "experiments/results/contact_statistics_results.h"
#include "experiments/results/results_file.h"
#include "reports/documents/run_page.h"
#include "tests/support/full_case.h"
#include "tests/support/read_text.h"

namespace firn::test {

// A promise that was not kept.
struct Broken : std::logic_error {
  using std::logic_error::logic_error;
};

inline void require(bool kept, const std::string& promise) {
  if (!kept) throw Broken(promise);
}

// True when the reader has accepted.
inline bool accepts(const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const InputError& e) {
    const std::string message = e.what();
    require(!message.empty() && message.find('\n') == std::string::npos,
            "a message is one line: " + message);
    return false;
  } catch (const Broken&) {
    throw;
  } catch (const std::exception& e) {
    throw Broken(std::string("a reader throws InputError alone; this is another: ") + e.what());
  }
}

inline void require_finite_tables(const std::filesystem::path& folder) {
  static const std::regex infinite(R"((^|[,\n])-?inf([,\n]|$))");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".csv") continue;
    require(!std::regex_search(read_text(entry.path()), infinite),
            "tables are finite: " + entry.path().string());
  }
}

// Every number of 32 bits in the VTK files of a folder.
inline void require_finite_vtk(const std::filesystem::path& folder) {
  static const std::regex array("<DataArray type=\"Float32\"[^>]*offset=\"([0-9]+)\"");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".vtp") continue;
    const std::string bytes = read_text(entry.path());
    const std::string mark = "<AppendedData encoding=\"raw\">\n_";
    const std::size_t data = bytes.find(mark) + mark.size();
    const std::string head = bytes.substr(0, data);
    for (std::sregex_iterator m(head.begin(), head.end(), array), end; m != end; ++m) {
      const std::size_t at = data + std::stoul((*m)[1]);
      std::uint64_t size = 0;
      std::memcpy(&size, bytes.data() + at, sizeof(size));
      for (std::size_t k = 0; k + 4 <= size; k += 4) {
        float value = 0;
        std::memcpy(&value, bytes.data() + at + 8 + k, 4);
        require(std::isfinite(value), "pictures are finite: " + entry.path().string());
      }
    }
  }
}

inline void require_finite(const std::vector<Response>& responses) {
  for (const Response& r : responses)
    for (const double value : r.value) require(!std::isinf(value), "is finite: " + r.name);
}

// A case that starts from the last frame of the file.
inline Case start_from(const std::string& file) {
  std::string text = kFullCase;
  const std::size_t first = text.find("[[particles]]"), last = text.find("[[motion_frames]]");
  text.replace(first, last - first, "[initial_state]\nfile = \"" + file + "\"\ntime = \"4 ms\"\n");
  const std::size_t bonds = text.find("[[bonds]]");
  text.resize(bonds);
  return read_case_text(text, "start.toml", ".");
}

// All of them over one file; how many accepted it. A page takes a process that draws.
inline int read_everything(const std::string& file, const std::filesystem::path& folder,
                           bool with_page = true) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  int accepted = accepts([&] {
    const Recording recording(file);
    accepts([&] { require_finite(measure(recording)); });
    accepts([&] { require_finite(recording.responses()); });
    accepts([&] {
      export_csv(recording, (folder / "csv").string());
      require_finite_tables(folder / "csv");
    });
    accepts([&] {
      export_vtk(recording, (folder / "vtk").string());
      require_finite_vtk(folder / "vtk");
    });
    accepts([&] { recording.has_checkpoint(); });
  });
  if (with_page)
    accepted += accepts([&] { run_page(file).write((folder / "page.html").string()); });
  accepted += accepts([&] {
    const Case c = start_from(file);
    for (const Case::InitialParticle& p : c.placed)
      require(p.position.allFinite() && p.velocity.allFinite() && std::isfinite(p.insert_time),
              "a start is finite");
  });
  return accepted;
}

}  // namespace firn::test
