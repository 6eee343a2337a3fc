// Results files of format 1, which have other names: every reader gives the same as of a new file.
#include "tests/support/first_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "experiments/results/bond_results.h"
#include "experiments/results/contact_statistics_results.h"
#include "experiments/results/results_file.h"
#include "tests/app/program.h"
#include "tests/support/full_case.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// The same run with new and with first names, under the same name in two folders.
class FirstFormat : public testing::Test {
 protected:
  static void make(const std::string& file, bool half) {
    if (half)
      test::run_half_of_full_case(file);
    else
      test::run_full_case(file);
  }
  void prepare(bool half) {
    make(of(now_), half);
    fs::copy_file(of(now_), of(old_));
    EXPECT_GT(test::use_first_names(of(old_)), 30);
  }
  static std::string of(const Folder& folder) { return (folder.path() / "run.h5").string(); }

  void expect_same(const std::vector<std::string>& arguments) {
    const Outcome now = now_.firn(arguments), old = old_.firn(arguments);
    EXPECT_EQ(now.status, 0) << now.err;
    EXPECT_EQ(old.status, 0) << old.err;
    EXPECT_EQ(old.out, now.out) << arguments[0];
  }
  static std::map<std::string, std::string> files_below(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file())
        files[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
    return files;
  }

  Folder now_, old_;
};

TEST_F(FirstFormat, IsReadByEachCommand) {
  prepare(false);
  expect_same({"measure", "run.h5", "--json"});
  expect_same({"export", "run.h5", "--to", "csv", "-o", "csv"});
  const auto tables = files_below(now_.path() / "csv");
  EXPECT_GT(tables.size(), 8u);
  EXPECT_EQ(files_below(old_.path() / "csv"), tables);
  expect_same({"export", "run.h5", "--to", "vtk", "-o", "vtk"});
  EXPECT_EQ(files_below(old_.path() / "vtk"), files_below(now_.path() / "vtk"));
  expect_same({"report", "run.h5", "-o", "page.html"});
  EXPECT_EQ(read_text(old_.path() / "page.html"), read_text(now_.path() / "page.html"));
  expect_same({"contacts", "run.h5", "--time", "3 ms", "--json"});
}

TEST_F(FirstFormat, HasTheSameContents) {
  prepare(false);
  const Recording now(of(now_)), old(of(old_));
  ASSERT_EQ(old.series_list().size(), now.series_list().size());
  for (std::size_t i = 0; i < now.series_list().size(); ++i)
    EXPECT_EQ(old.series_list()[i].path, now.series_list()[i].path);
  EXPECT_EQ(old.measured(), now.measured());
  const auto sorted_names = [](const Recording& recording) {
    std::set<std::string> names;
    for (const Response& r : recording.responses()) names.insert(r.name);
    return names;
  };
  EXPECT_EQ(sorted_names(old), sorted_names(now));
  EXPECT_TRUE(sorted_names(old).contains("largest_compressive_load"));
  ASSERT_EQ(old.stages().size(), now.stages().size());
  for (std::size_t i = 0; i < now.stages().size(); ++i)
    EXPECT_EQ(old.stages()[i].end_reason, now.stages()[i].end_reason);
  EXPECT_EQ(contact_events(old).size(), contact_events(now).size());
  EXPECT_EQ(compressive_loads(old).size(), compressive_loads(now).size());
  ASSERT_EQ(bond_outcomes(old).size(), bond_outcomes(now).size());
  for (std::size_t i = 0; i < bond_outcomes(now).size(); ++i)
    EXPECT_EQ(bond_outcomes(old)[i].mode, bond_outcomes(now)[i].mode);

  testing::internal::CaptureStderr();
  EXPECT_EQ(now.series("/health/patches"), now.series("/diagnostics/patches"));
  EXPECT_EQ(old.series("/health/patches"), now.series("/diagnostics/patches"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("\"/health/patches\" is now \"/diagnostics/patches\""));
}

// A file keeps its names when its run is resumed.
TEST_F(FirstFormat, IsResumed) {
  prepare(true);
  for (const Folder* folder : {&now_, &old_}) {
    const Outcome o = folder->firn({"run", "--resume", "run.h5", "-q"});
    EXPECT_EQ(o.status, 0) << o.err;
  }
  expect_same({"measure", "run.h5", "--json"});
  const hdf5::File file = hdf5::File::open(of(old_), hdf5::File::Access::read);
  EXPECT_TRUE(file.contains("/health/patches"));
  EXPECT_FALSE(file.contains("/diagnostics"));
  EXPECT_TRUE(file.has_attribute("/", "measured"));
  EXPECT_FALSE(file.has_attribute("/", "responses_complete"));
  expect_same({"export", "run.h5", "--to", "csv", "-o", "csv"});
  EXPECT_EQ(files_below(old_.path() / "csv"), files_below(now_.path() / "csv"));
}

TEST_F(FirstFormat, OtherFormatsAreRefused) {
  make(of(now_), false);
  hdf5::File file = hdf5::File::open(of(now_), hdf5::File::Access::write);
  file.set_attribute("/", "format_version", results::kFormat + 1);
  file.close();
  const Outcome o = now_.firn({"measure", "run.h5"});
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("run.h5: /: is of format 3; expected 2 or no format_version"));
}

}  // namespace
}  // namespace firn::cli
