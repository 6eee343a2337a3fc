// CSV files: the ways of motions, and the numbers behind measurements, each kind as its reader
// takes it.
#include <cmath>
#include <deque>

#include "experiments/case_reader/model/motion_csv.h"
#include "experiments/measurements/measured_data.h"
#include "tests/fuzz/fuzz_target.h"

namespace {

using namespace firn;

// [data] of measurements, with columns as the corpus has them.
constexpr const char* kKinds[] = {
    "kind = \"values\"\nresponse = \"r\"\nunit = \"mm\"\ncolumn = \"way\"\n",
    "kind = \"classes\"\nresponse = \"r\"\nclasses = \"class\"\ncounts = \"count\"\n",
    "kind = \"trace\"\nresponse = \"r\"\nunit = \"mm\"\ncolumn = \"way\"\ntime = \"time\"\n"
    "threshold = \"1 mm\"\ndead_time = \"1 ms\"\n",
    "kind = \"curve\"\nresponse = \"r\"\nx = \"time\"\nx_unit = \"s\"\ny = \"way\"\nunit = \"m\"\n"
    "repeat = \"class\"\n"};

// Parsed once: the input is the CSV file that they name.
struct Kinds {
  Kinds() {
    for (const char* kind : kKinds)
      documents.emplace_back("file = \"data.csv\"\n" + std::string(kind), "measurement.toml");
  }
  fuzz::Folder folder;
  std::deque<TomlDocument> documents;
};

void require_finite(const std::vector<double>& values, const char* what) {
  for (const double v : values) fuzz::require(std::isfinite(v), what);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Kinds kinds;
  const std::string file = kinds.folder.put("data.csv", fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const MotionCsv m = read_motion_csv(file, "time", "way", dimension::length);
    fuzz::require(m.times.size() == m.positions.size() && m.times.size() == m.lines.size(),
                  "every row has a time, a position and a line");
    require_finite(m.times, "times are finite");
    require_finite(m.positions, "positions are finite");
  });
  for (TomlDocument& document : kinds.documents) {
    fuzz::accepts([&] {
      const MeasuredData d = read_measured_data(TomlTable::root(document), kinds.folder.path("."));
      fuzz::require(d.present, "a file that is there is read");
      require_finite(d.values, "values are finite");
      require_finite(d.samples, "samples are finite");
      require_finite(d.counts, "counts are finite");
      fuzz::require(d.classes.size() == d.counts.size(), "every class has its count");
      for (const MeasuredData::Repeat& r : d.repeats) {
        fuzz::require(r.x.size() == r.y.size(), "every x has its y");
        require_finite(r.x, "x is finite");
        require_finite(r.y, "y is finite");
      }
    });
  }
  return 0;
}
