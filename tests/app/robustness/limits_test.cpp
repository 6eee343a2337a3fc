// Inputs beyond the limits of input_limits.h: one line, status 2, soon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <functional>

#include "tests/app/program.h"
#include "tests/app/robustness/hostile_inputs.h"

namespace firn::cli {
namespace {

using testing::AnyOf;
using testing::HasSubstr;

struct Reader {
  const char* what;
  std::string file;  // that the command reads
  std::vector<std::string> command;
};

// Every command that reads a file of a user, with all others in order.
std::vector<Reader> toml_readers() {
  return {{"case", "case.toml", {"run", "case.toml"}},
          {"facts", "case.toml", {"shape", "case.toml"}},
          {"replay", "case.toml", {"contacts", "case.toml"}},
          {"included", "part.toml", {"run", "including.toml"}},
          {"sweep", "sweep.toml", {"sweep", "sweep.toml"}},
          {"its case", "case.toml", {"sweep", "sweep.toml"}},
          {"study", "study.toml", {"calibrate", "study.toml"}},
          {"suite", "suite.toml", {"validate", "suite.toml"}},
          {"measurement", "mass.toml", {"validate", "suite.toml"}}};
}
std::vector<Reader> other_readers() {
  return {{"results", "x.h5", {"measure", "x.h5"}},
          {"export", "x.h5", {"export", "x.h5", "--to", "csv"}},
          {"resumed", "x.h5", {"run", "--resume", "x.h5"}},
          {"page", "x.h5", {"report", "x.h5"}},
          {"trace", "x.trace", {"compare-traces", "x.trace", "x.trace"}},
          {"records", "x.json", {"materials", "import", "x.json"}},
          {"database", "x.db", {"materials", "list", "--database", "x.db"}},
          {"results.json", "results.json", {"report", "results.json"}},
          {"STL", "x.stl", {"shape", "x.stl"}},
          {"OBJ", "x.obj", {"shape", "x.obj"}},
          {"mesh of a case", "x.stl", {"run", "meshed.toml"}},
          {"table of a motion", "x.csv", {"run", "moved.toml"}},
          {"start", "x.h5", {"run", "started.toml"}}};
}

class Limits : public testing::Test {
 protected:
  Limits() {
    const std::string base = hostile::rich_case;
    folder_.write("case.toml", base);
    folder_.write("including.toml", "include = \"part.toml\"\n" + base);
    folder_.write("part.toml", "");
    folder_.write("sweep.toml", hostile::sweep_file);
    folder_.write("study.toml", hostile::study_file);
    folder_.write("suite.toml", hostile::suite_file);
    folder_.write("mass.toml", hostile::mass_file);
    folder_.write("claims.toml", hostile::claims_file);
    folder_.write("meshed.toml", base +
                                     "\n[shapes.m]\nkind = \"mesh\"\nfile = \"x.stl\"\n"
                                     "length_unit = \"mm\"\nmaterial = \"ice\"\n");
    folder_.write("moved.toml",
                  base +
                      "\n[[boundaries]]\nname = \"moved\"\nmaterial = \"plastic\"\nkind = "
                      "\"plane\"\nnormal = [0, 0, 1]\npoint = \"0 0 -1 m\"\nmotions = [{kind = "
                      "\"translation_table\", direction = [0, 0, 1], file = "
                      "\"x.csv\"}]\n");
    folder_.write("started.toml", base + "\n[initial_state]\nfile = \"x.h5\"\n");
  }

  // One line and status 2, in seconds.
  std::string refusal(const std::vector<std::string>& command, double most_seconds = 10) {
    const auto begin = std::chrono::steady_clock::now();
    const Outcome o = folder_.firn(command);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_EQ(o.status, 2) << o.err.substr(0, 1000);
    EXPECT_EQ(lines(o.err), 1u) << o.err.substr(0, 1000);
    EXPECT_THAT(o.err, HasSubstr("expected"));
    EXPECT_LT(o.err.size(), 5000u);
    EXPECT_LT(seconds, most_seconds);
    return o.err;
  }

  void replace(const std::string& name,
               const std::function<void(const std::filesystem::path&)>& by) {
    const auto file = folder_.path() / name;
    const std::string kept = std::filesystem::exists(file) ? read_text(file) : "";
    std::filesystem::remove_all(file);
    by(file);
    kept_ = {name, kept};
  }
  void put_back() {
    std::filesystem::remove_all(folder_.path() / kept_.first);
    folder_.write(kept_.first, kept_.second);
  }

  Folder folder_;
  std::pair<std::string, std::string> kept_;
};

TEST_F(Limits, OnlyRegularFilesAreRead) {
  std::vector<Reader> all = toml_readers();
  for (const Reader& reader : other_readers()) all.push_back(reader);
  for (const Reader& reader : all) {
    SCOPED_TRACE(reader.what);
    replace(reader.file, [](const auto& file) { ASSERT_EQ(mkfifo(file.c_str(), 0600), 0); });
    EXPECT_THAT(refusal(reader.command),
                AnyOf(HasSubstr("not a regular file"), HasSubstr("is not a file")));
    put_back();
    replace(reader.file,
            [](const auto& file) { std::filesystem::create_symlink("/dev/zero", file); });
    EXPECT_THAT(refusal(reader.command),
                AnyOf(HasSubstr("not a regular file"), HasSubstr("is not a file")));
    put_back();
    replace(reader.file, [](const auto& file) { std::filesystem::create_directory(file); });
    EXPECT_THAT(refusal(reader.command), AnyOf(HasSubstr("is a folder"), HasSubstr("is not a file"),
                                               HasSubstr("does not exist")));
    put_back();
  }
}

// Sparse files: their length is known before they are read.
TEST_F(Limits, LongFilesAreNotRead) {
  for (const Reader& reader : toml_readers()) {
    SCOPED_TRACE(reader.what);
    replace(reader.file, [](const auto& file) {
      std::ofstream(file) << "";
      std::filesystem::resize_file(file, std::uintmax_t{1} << 40);
    });
    EXPECT_THAT(refusal(reader.command), HasSubstr("is longer than 134217728 bytes"));
    put_back();
  }
}

TEST_F(Limits, TomlIsNotNestedDeeply) {
  const auto times = [](std::string_view part, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += part;
    return text;
  };
  const std::vector<std::pair<std::string, const char*>> texts = {
      {"a" + times(".a", 40000) + " = 1\n", "more than 32 parts"},
      {"[a" + times(".a", 40000) + "]\nb = 1\n", "more than 32 parts"},
      {"[[a" + times(" . \"a\"", 40000) + "]]\n", "more than 32 parts"},
      {"a = {b" + times(".'b'", 40000) + " = 1}\n", "more than 32 parts"},
      {"a = " + times("[", 100000) + times("]", 100000) + "\n", "nested more than 32 deep"},
      {"a = " + times("{a = ", 100000), "nested more than 32 deep"},
      {"a = " + times("[{a = ", 100000), "nested more than 32 deep"},
      {times("[[a]]\n", 300000), "has more than 200000 tables"},
      {"a = [" + times("{},", 300000) + "]\n", "has more than 200000 tables"},
  };
  for (const Reader& reader : toml_readers())
    for (const auto& [text, said] : texts) {
      SCOPED_TRACE(reader.what);
      replace(reader.file, [&content = text](const auto& file) { std::ofstream(file) << content; });
      EXPECT_THAT(refusal(reader.command), HasSubstr(said));
      put_back();
    }
  const std::string deep = "a" + times(".a", 60000);
  EXPECT_THAT(refusal({"run", "case.toml", "--set", deep + "=1"}), HasSubstr("more than 32 parts"));
  EXPECT_THAT(refusal({"run", "case.toml", "--set", "case.seed=" + times("[", 60000)}),
              HasSubstr("nested more than 32 deep"));
  EXPECT_THAT(refusal({"run", "case.toml", "--set", "case.seed={" + deep + "=1}"}),
              HasSubstr("more than 32 parts"));
}

// A million entries: refused by their number, in linear time.
TEST_F(Limits, ListsAreNotEndless) {
  const std::string base = hostile::rich_case;
  const auto many = [&](const std::string& key, const std::string& entry, int count) {
    std::string text = base;
    for (int i = 0; i < count; ++i) text += "[[" + key + "]]\n" + entry;
    folder_.write("many.toml", text);
    return refusal({"run", "many.toml"}, 30);
  };
  const std::string stage = "name = \"s\"\nmax_duration = \"1 s\"\n";
  EXPECT_THAT(many("stages", stage, 1000000), HasSubstr("has more than 200000 tables"));
  EXPECT_THAT(many("stages", stage, 20000), HasSubstr("expected at most 10000"));
  EXPECT_THAT(many("particles", "shape = \"cube\"\nposition = \"0 0 0 m\"\n", 150000),
              HasSubstr("expected at most 100000"));
  EXPECT_THAT(many("boundaries", "name = \"b\"\n", 20000), HasSubstr("expected at most 10000"));
  EXPECT_THAT(many("measure", "kind = \"load\"\n", 20000), HasSubstr("expected at most 10000"));
  std::string materials = base;
  for (int i = 0; i < 1000; ++i) materials += "[materials.m" + std::to_string(i) + "]\n";
  folder_.write("many.toml", materials);
  EXPECT_THAT(refusal({"run", "many.toml"}), HasSubstr("expected at most 200"));
}

TEST_F(Limits, IncludesDoNotMultiply) {
  // 40 files that include the next one 40 times each: 40^8 files.
  for (int level = 1; level < 8; ++level) {
    std::string list;
    for (int i = 0; i < 40; ++i) list += "\"level" + std::to_string(level + 1) + ".toml\",";
    folder_.write("level" + std::to_string(level) + ".toml", "include = [" + list + "]\n");
  }
  folder_.write("level8.toml", "");
  EXPECT_THAT(refusal({"run", "level1.toml"}), HasSubstr("more than 100 files"));
}

TEST_F(Limits, PairsOfBondsAreNotEndless) {
  const auto with_pairs = [&](const std::string& pairs) {
    std::string text = hostile::rich_case;
    const std::string old = "[[0, 1]]";
    text.replace(text.find(old), old.size(), pairs);
    folder_.write("bonded.toml", text);
    return refusal({"run", "bonded.toml"});
  };
  EXPECT_THAT(with_pairs("[[0, 1], [1, 0]]"), HasSubstr("pairs: joins 1 and 0 twice"));
  std::string many = "[";
  for (int i = 0; i < 300000; ++i) many += "[0,1],";
  EXPECT_THAT(with_pairs(many + "]"), HasSubstr("has 300000 entries; expected at most 100000"));
}

// The plan of a batch takes memory for each run.
TEST_F(Limits, BatchesAreNotEndless) {
  const auto changed = [&](std::string text, const std::string& old, const std::string& by,
                           const char* command) {
    text.replace(text.find(old), old.size(), by);
    folder_.write("many.toml", text);
    return refusal({command, "many.toml", "--progress", "none"});
  };
  for (const char* key :
       {"center_replicates = 3", "design_points = 4", "replicates_per_point = 1",
        "refine_rounds = 0", "refine_points = 1", "confirmation_replicates = 2"}) {
    const std::string old = key, name = old.substr(0, old.find(' '));
    EXPECT_THAT(changed(hostile::study_file, old, name + " = 1000000000", "calibrate"),
                HasSubstr("budget." + name + ": is 1000000000; expected at most 100000"));
  }
  // Two numbers that fit, and their product does not.
  EXPECT_THAT(changed(hostile::study_file, "design_points = 4\nreplicates_per_point = 1",
                      "design_points = 90000\nreplicates_per_point = 90000", "calibrate"),
              HasSubstr("budget: makes more than 100000 runs"));
  EXPECT_THAT(changed(hostile::sweep_file, "[[vary]]", "seeds = 60000\n[[vary]]", "sweep"),
              HasSubstr("more than 100000 runs"));
  std::string variants = "seeds = 1\n";
  for (int i = 0; i < 200; ++i)
    variants += "[[experiments.variants]]\nname = \"v" + std::to_string(i) +
                "\"\nset = { \"case.seed\" = 3 }\nseeds = 9000\n";
  EXPECT_THAT(changed(hostile::suite_file, "seeds = 1\n", variants, "validate"),
              HasSubstr("variants: make more than 100000 runs"));
}

TEST_F(Limits, JsonIsNeitherDeepNorWide) {
  const std::string deep = std::string(1000000, '[');
  std::string objects, keys = "{";
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  for (int i = 0; i < 100000; ++i) keys += "\"k" + std::to_string(i) + "\":0,";
  keys += "\"study\":0}";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"materials", "import", "x.json"}, {"report", "x.json"}}) {
    folder_.write("x.json", deep);
    EXPECT_THAT(refusal(command), HasSubstr("nested more than 64 deep"));
    folder_.write("x.json", objects);
    EXPECT_THAT(refusal(command), HasSubstr("nested more than 64 deep"));
    folder_.write("x.json", keys);
    EXPECT_THAT(refusal(command), HasSubstr("more than 10000 keys"));
    folder_.write("x.json", "{\"study\": 1e999}");
    EXPECT_THAT(refusal(command), HasSubstr("expected finite numbers"));
  }
}

TEST_F(Limits, CsvIsNeitherLongNorWide) {
  folder_.write("x.csv", std::string(2000, ',') + "\n");
  EXPECT_THAT(refusal({"run", "moved.toml"}), HasSubstr("more than 1000 fields"));
  std::string rows = "time [s],way [m]\n";
  for (int i = 0; i < 1100000; ++i) rows += "1,2\n";
  folder_.write("x.csv", rows);
  EXPECT_THAT(refusal({"run", "moved.toml"}, 30), HasSubstr("more than 1000000 rows"));
}

}  // namespace
}  // namespace firn::cli
