// Every object of a results file is in the schema, and nothing that breaks it is accepted.
#include "experiments/results/results_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <random>
#include <set>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/results/checkpoint.h"
#include "experiments/results/contact_statistics_results.h"
#include "experiments/results/results_file.h"
#include "tests/support/error_of.h"
#include "tests/support/full_case.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"
#include "tests/support/results_mutations.h"
#include "tests/support/results_readers.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                 kInf = std::numeric_limits<double>::infinity();

// The finished run and the interrupted one, made once.
class ResultsSchema : public ResultsFolder {
 protected:
  static const test::ScratchFolder& made() {
    static const test::ScratchFolder folder("full");
    static const bool once = [] {
      test::run_full_case((folder.path() / "whole.h5").string());
      test::run_half_of_full_case((folder.path() / "half.h5").string());
      return true;
    }();
    static_cast<void>(once);
    return folder;
  }
  static std::string whole() { return (made().path() / "whole.h5").string(); }
  static std::string half() { return (made().path() / "half.h5").string(); }

  // The message about a changed copy of a file; empty: it is accepted.
  std::string error_after(const std::string& of,
                          const std::function<void(test::ResultsMutator&)>& change) const {
    const std::string file = path("changed.h5");
    fs::copy_file(of, file, fs::copy_options::overwrite_existing);
    {
      test::ResultsMutator mutator(file, [](std::size_t) { return std::size_t{0}; });
      change(mutator);
    }
    return error_of(file);
  }
  static std::string error_of(const std::string& file) {
    return test::error_if_any([&] { read_case(Recording(file)); });
  }
};

TEST_F(ResultsSchema, KnowsEveryObjectThatIsWritten) {
  std::set<std::string_view> seen, seen_attributes;
  for (const std::string& file : {whole(), half()}) {
    const hdf5::File open = hdf5::File::open(file, hdf5::File::Access::read);
    const results::Contents contents = results::check_file(open);
    for (const hdf5::Object& object : open.objects()) {
      if (object.is_group) continue;
      const auto known = contents.datasets.find(object.path);
      ASSERT_NE(known, contents.datasets.end())
          << object.path << " is written; expected it in results_schema.cpp";
      seen.insert(known->second->path);
      EXPECT_EQ(known->second->type, object.type) << object.path;
      if (open.has_attribute(object.path, "unit") && !object.path.starts_with("/responses/")) {
        EXPECT_EQ(open.text_attribute(object.path, "unit"), known->second->unit) << object.path;
      }
      for (const results::Attribute& a : results::attributes())
        if (open.has_attribute(a.object == "/" ? "/" : object.path, std::string(a.name)))
          seen_attributes.insert(a.name);
    }
  }
  for (const results::Dataset& d : results::datasets())
    EXPECT_TRUE(seen.contains(d.path))
        << d.path << " is in the schema and not in tests/support/full_case.h";
  for (const results::Attribute& a : results::attributes())
    EXPECT_TRUE(seen_attributes.contains(a.name)) << a.name;
}

TEST_F(ResultsSchema, HasSomethingInEachList) {
  const Recording recording(whole());
  EXPECT_EQ(recording.status(), "finished");
  EXPECT_GT(contact_events(recording).size(), 0u);
  EXPECT_GT(boundary_loads(recording).at(0).end.size(), 2u);
  EXPECT_GT(recording.strings("/limit_switches/name").size(), 0u);
  EXPECT_GT(recording.strings("/bonds/name").size(), 0u);
  const std::vector<double> exits = recording.exit_time();
  EXPECT_TRUE(std::ranges::any_of(exits, [](double t) { return t > 0; }));
  EXPECT_TRUE(Recording(half()).has_checkpoint());
  const fs::path folder = path("read");
  EXPECT_EQ(test::read_everything(whole(), folder), 3);
}

TEST_F(ResultsSchema, FindsGateTimesOfHalfLength) {
  const std::string e = error_after(whole(), [](auto& m) {
    const auto shape = m.shape_of("/particles/sensor_time");
    m.replace("/particles/sensor_time", {shape[0], shape[1] / 2}, H5T_NATIVE_DOUBLE);
  });
  EXPECT_EQ(e, path("changed.h5") +
                   ": /particles/sensor_time: has the wrong shape, [2, 3]; expected [2, 7], as "
                   "/particles/id");
}

TEST_F(ResultsSchema, NamesTheDatasetOfAnotherLength) {
  for (const char* dataset : {"/particles/batch", "/particles/insert_time", "/particles/outlet",
                              "/particles/shape", "/particles/mass"}) {
    const std::string e = error_after(whole(), [&](auto& m) {
      m.replace(dataset, {3},
                std::string(dataset).ends_with("e") && dataset[12] == 'n' ? H5T_NATIVE_DOUBLE
                : std::string(dataset) == "/particles/mass"               ? H5T_NATIVE_DOUBLE
                                                                          : H5T_NATIVE_INT);
    });
    EXPECT_EQ(e, path("changed.h5") + ": " + dataset + ": has 3 entries; expected 7, as " +
                     "/particles/id");
  }
  EXPECT_THAT(error_after(whole(), [](auto& m) { m.replace("/bonds/a", {2}, H5T_NATIVE_INT); }),
              HasSubstr(": /bonds/a: has 2 entries; expected 1, as /bonds/name"));
}

// What is wrong is one value.
TEST_F(ResultsSchema, NamesTheValueThatCannotBe) {
  struct Wrong {
    const char* dataset;
    double value;
    const char* message;
  };
  const Wrong all[] = {
      {"/particles/mass", -26, "/particles/mass: entry 1 is -26; expected a finite number above 0"},
      {"/particles/mass", kInf, "/particles/mass: entry 1 is inf; "},
      {"/particles/mass", kNaN, "/particles/mass: entry 1 is nan; "},
      {"/particles/mass", 0, "/particles/mass: entry 1 is 0; "},
      {"/particles/exit_time", kInf, "/particles/exit_time: entry 1 is inf; "},
      {"/particles/exit_time", -1, "/particles/exit_time: entry 1 is -1; "},
      {"/particles/insert_time", -kInf, "/particles/insert_time: entry 1 is -inf; "},
      {"/particles/sensor_time", 1e300, "/particles/sensor_time: entry [0, 1] is 1e+300; "},
      {"/particles/shape", 2, "/particles/shape: entry 1 is 2; expected 0 ... 1"},
      {"/particles/shape", -1, "/particles/shape: entry 1 is -1; expected 0 ... 1"},
      {"/particles/outlet", 2, "/particles/outlet: entry 1 is 2; expected -1 ... 1"},
      {"/particles/batch", -2, "/particles/batch: entry 1 is -2; expected -1 or more"},
      {"/particles/id", 5, "/particles/id: entry 1 is 5; expected 0, 1, 2, ..."},
      {"/frames/time", kInf, "/frames/time: entry 1 is inf; "},
      {"/frames/time", -1, "/frames/time: entry 1 is -1; "},
      {"/frames/time", 1, "/frames/time: entry 2 is 0.00101"},
      {"/statistics/boundaries/panel/triangles", 1e6,
       "/statistics/boundaries/panel/triangles: entry [0, 1] is 1000000; expected 0 ... "},
      {"/particles/compressive_load_body_1", 99,
       "/particles/compressive_load_body_1: entry 1 is 99; expected "
       "-5 ... 6, or NaN"},
      {"/stages/end", -kInf, "/stages/end: entry 1 is -inf; "},
  };
  for (const Wrong& wrong : all) {
    const std::string e =
        error_after(whole(), [&](auto& m) { m.overwrite(wrong.dataset, 1, 1, wrong.value); });
    EXPECT_THAT(e, testing::StartsWith(path("changed.h5") + ": " + wrong.message));
    EXPECT_THAT(e, testing::Not(HasSubstr("\n")));
  }
  EXPECT_THAT(error_after(whole(), [](auto& m) { m.overwrite("/bonds/b", 0, 1, 7); }),
              HasSubstr("/bonds/b: entry 0 is 7; expected -5 ... 6"));
  EXPECT_THAT(error_after(whole(), [](auto& m) { m.overwrite("/bonds/b", 0, 1, -6); }),
              HasSubstr("/bonds/b: entry 0 is -6; expected -5 ... 6"));
}

// Tables that grow are checked when they are read.
TEST_F(ResultsSchema, NamesTheValueOfATableWhenItIsRead) {
  const auto error_reading = [&](const char* dataset, double value, const auto& read) {
    EXPECT_EQ(error_after(whole(), [&](auto& m) { m.overwrite(dataset, 1, 1, value); }), "");
    const Recording recording(path("changed.h5"));
    return test::error_of([&] { read(recording); });
  };
  const auto events = [](const Recording& r) { contact_events(r); };
  EXPECT_THAT(error_reading("/events/body_a", 7, events),
              HasSubstr("/events/body_a: entry 1 is 7; expected 0 ... 6"));
  EXPECT_THAT(error_reading("/events/body_b", -6, events),
              HasSubstr("/events/body_b: entry 1 is -6; expected -5 ... 6"));
  EXPECT_THAT(error_reading("/events/duration", kInf, events), HasSubstr("/events/duration: "));
  const auto frame = [](const Recording& r) { r.frame(0); };
  EXPECT_THAT(error_reading("/frames/position", kInf, frame),
              HasSubstr("/frames/position: entry [0, 0, 1] is inf; expected finite numbers, or "));
  EXPECT_THAT(error_reading("/frames/velocity", kNaN, frame),
              HasSubstr("/frames/velocity: entry [0, 0, 0] is "));
  EXPECT_THAT(error_reading("/frames/orientation", 7, frame), HasSubstr("expected a unit quat"));
  EXPECT_THAT(error_reading("/energy/kinetic", -1, [](auto& r) { r.series("/energy/kinetic"); }),
              HasSubstr("/energy/kinetic: entry 1 is -1; expected a finite number, 0 or more"));
}

// Dataspaces and types that no writer of Firn makes, in every dataset.
TEST_F(ResultsSchema, RefusesOtherSpacesAndTypesOfEveryDataset) {
  std::vector<std::string> datasets;
  for (const hdf5::Object& object : hdf5::File::open(whole(), hdf5::File::Access::read).objects())
    if (!object.is_group) datasets.push_back(object.path);
  EXPECT_GT(datasets.size(), 100u);
  for (const std::string& dataset : datasets) {
    EXPECT_THAT(
        error_after(whole(), [&](auto& m) { m.replace(dataset, {}, H5T_NATIVE_DOUBLE, H5S_NULL); }),
        HasSubstr(dataset + ": h"));
    EXPECT_THAT(error_after(whole(),
                            [&](auto& m) {
                              m.replace(dataset, {5, 0, 3}, H5T_NATIVE_INT);
                            }),
                HasSubstr(dataset + ": h"));
    EXPECT_THAT(
        error_after(whole(),
                    [&](auto& m) { m.replace(dataset, m.shape_of(dataset), H5T_STD_I16LE); }),
        HasSubstr(dataset + ": holds another type; expected "));
  }
}

TEST_F(ResultsSchema, RefusesWhatLeadsOutOfTheFile) {
  using M = test::ResultsMutator;
  EXPECT_THAT(error_after(whole(),
                          [](M& m) {
                            m.remove("/particles/tag");
                            H5Lcreate_external("/etc/passwd", "/x", m.file(), "/particles/tag",
                                               H5P_DEFAULT, H5P_DEFAULT);
                          }),
              HasSubstr(": /particles/tag: is a link to elsewhere"));
  EXPECT_THAT(
      error_after(whole(),
                  [](M& m) {
                    m.remove("/particles/mass");
                    const test::Hid list(H5Pcreate(H5P_DATASET_CREATE));
                    H5Pset_external(list, "/etc/passwd", 0, 7 * 8);
                    const hsize_t n = 7;
                    const test::Hid space(H5Screate_simple(1, &n, nullptr));
                    const test::Hid made(H5Dcreate2(m.file(), "/particles/mass", H5T_NATIVE_DOUBLE,
                                                    space, H5P_DEFAULT, list, H5P_DEFAULT));
                  }),
      HasSubstr(": /particles/mass: keeps its values in another file"));
  EXPECT_THAT(error_after(whole(),
                          [](M& m) {
                            H5Lcreate_hard(m.file(), "/frames", m.file(), "/frames/again",
                                           H5P_DEFAULT, H5P_DEFAULT);
                          }),
              HasSubstr("is a second name of another object"));
}

TEST_F(ResultsSchema, RefusesNestedAndCountlessGroupsAtOnce) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(error_after(whole(), [](auto& m) { m.nest_groups("/deep", 3000); }),
              HasSubstr("groups deep; expected at most 32"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

// Claims of values that the file does not have.
TEST_F(ResultsSchema, RefusesMoreValuesThanTheFileHolds) {
  for (const bool in_chunks : {false, true}) {
    const std::string e = error_after(whole(), [&](test::ResultsMutator& m) {
      m.remove("/events");
      m.remove("/statistics/boundary_name");
      m.remove("/statistics");
      m.remove("/particles/compressive_load");
      m.remove("/particles/compressive_load_time");
      m.remove("/particles/compressive_load_body_0");
      m.remove("/particles/compressive_load_body_1");
      m.remove("/responses");
      const hsize_t n = hsize_t{1} << 40, chunk = 1000;
      const test::Hid list(H5Pcreate(H5P_DATASET_CREATE)), space(H5Screate_simple(1, &n, nullptr)),
          groups(H5Pcreate(H5P_LINK_CREATE));
      H5Pset_create_intermediate_group(groups, 1);
      if (in_chunks) H5Pset_chunk(list, 1, &chunk);
      const test::Hid made(H5Dcreate2(m.file(), "/responses/huge", H5T_NATIVE_DOUBLE, space, groups,
                                      list, H5P_DEFAULT));
    });
    EXPECT_THAT(e, HasSubstr("/responses/huge"));
  }
}

TEST_F(ResultsSchema, RefusesACompressedChunkThatIsTooShort) {
  // In place of the table of a large run: one whose chunks hold less than their rows.
  const std::string e = error_after(whole(), [](test::ResultsMutator& m) {
    const auto shape = m.shape_of("/frames/position");
    m.remove("/frames/position");
    const test::Hid list(H5Pcreate(H5P_DATASET_CREATE));
    std::vector<hsize_t> chunk = shape;
    chunk[0] = 1;
    H5Pset_chunk(list, 3, chunk.data());
    H5Pset_shuffle(list);
    H5Pset_deflate(list, 1);
    const test::Hid space(H5Screate_simple(3, shape.data(), nullptr));
    const test::Hid made(H5Dcreate2(m.file(), "/frames/position", H5T_NATIVE_DOUBLE, space,
                                    H5P_DEFAULT, list, H5P_DEFAULT));
    m.set_text("/frames/position", "unit", "m");
    const unsigned char zip[] = {0x78, 0x01, 0x63, 0x00, 0x00, 0x00, 0x01, 0x00, 0x01};
    for (hsize_t row = 0; row < shape[0]; ++row) {
      const hsize_t offset[] = {row, 0, 0};
      H5Dwrite_chunk(made, H5P_DEFAULT, 0, offset, sizeof(zip), zip);
    }
  });
  EXPECT_THAT(e, HasSubstr("/frames/position: the compressed values of row 0 are damaged"));
}

TEST_F(ResultsSchema, RefusesAFileOfAnotherCase) {
  const auto with_case = [&](const std::string& from, const std::string& to) {
    std::string text = test::full_case().resolved;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return error_after(whole(), [&](auto& m) { m.set_text("/", "case", text); });
  };
  EXPECT_THAT(with_case("count = 2", "count = 3"),
              HasSubstr("/particles/id: has 7 entries; expected 8, the particles of the case"));
  EXPECT_THAT(with_case("name = \"high\"", "name = \"top\""),
              HasSubstr("/sensors/name: entry 1 is \"high\"; expected \"top\""));
}

// Lengths and numbers of a checkpoint before the solver's own bytes, under a hash that fits.
TEST_F(ResultsSchema, GoesOnFromNoCheckpointWithListsOfOtherLengths) {
  const std::string file = path("resumed.h5");
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    std::mt19937_64 random(seed);
    fs::copy_file(half(), file, fs::copy_options::overwrite_existing);
    {
      hdf5::File open = hdf5::File::open(file, hdf5::File::Access::write);
      Checkpoint newest = read_checkpoints(open).front();
      remove_checkpoints(open);
      const std::uint64_t value = random() % 3 ? random() % 20 : random();
      const std::size_t word = random() % 120;
      std::memcpy(newest.payload.data() + 8 * word, &value, sizeof(value));
      ++newest.sequence;
      write_checkpoint(open, newest);
    }
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RunOptions options;
    try {
      resume(file, options);
    } catch (const InputError& e) {
      ++refused;
      EXPECT_THAT(e.what(), HasSubstr(file));
    }
  }
  EXPECT_GT(refused, 5);
}

// One to three changes of a good file: refused in one line, or read with finite results.
void try_members(const std::string& whole, const std::string& half, const fs::path& folder,
                 std::uint64_t first, int count) {
  const std::string file = (folder / "member.h5").string();
  int accepted = 0;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
    std::mt19937_64 random(seed);
    fs::copy_file(seed % 4 == 3 ? half : whole, file, fs::copy_options::overwrite_existing);
    std::string did;
    {
      test::ResultsMutator mutator(
          file, [&](std::size_t below) { return static_cast<std::size_t>(random() % below); });
      did = mutator.mutate();
    }
    SCOPED_TRACE(testing::Message() << "seed " << seed << ": " << did);
    try {
      accepted += test::read_everything(file, folder / "out", seed % 4 == 0) > 0;
    } catch (const test::Broken& e) {
      ADD_FAILURE() << e.what();
    }
  }
  EXPECT_GT(accepted, count / 50);
  EXPECT_LT(accepted, count / 2);
}

TEST_F(ResultsSchema, ReadersKeepTheirPromisesOverRandomMembers) {
  try_members(whole(), half(), path(""), 1, 250);
}

// In pieces that each end within the time limit of a test.
class ResultsSchemaLong : public ResultsSchema,
                          public testing::WithParamInterface<std::uint64_t> {};
TEST_P(ResultsSchemaLong, ReadersKeepTheirPromisesOverRandomMembers) {
  try_members(whole(), half(), path(""), 100000 + 750 * GetParam(), 750);
}
INSTANTIATE_TEST_SUITE_P(Members, ResultsSchemaLong,
                         testing::Range(std::uint64_t{0}, std::uint64_t{8}));

TEST(ResultsPage, IsMadeFromTheSchema) {
  const std::string page = test::read_text(FIRN_SOURCE_DIR "/docs/results.md");
  EXPECT_THAT(page, HasSubstr("<!-- schema -->\n" + results::description() + "<!-- end -->\n"))
      << "docs/results.md is not up to date: run scripts/update-results-page.sh";
}

}  // namespace
}  // namespace firn
