// Studies whose experiment is a program of the user.
#include "calibrate/study/user_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "calibrate/study/study_file.h"
#include "experiments/system/input_file.h"
#include "tests/support/environment.h"
#include "tests/support/error_of.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// y = 10 a + b^2 and z = b, with noise of the seed; counts its runs in the file COUNT.
constexpr const char* simulator = R"sh(#!/bin/sh
. ./input.txt
echo "$seed" >> "$2/count"
SPECIAL
awk -v a="$a" -v b="$b" -v s="$seed" 'BEGIN { srand(s * 7919 + 1); rand();
  n = rand() + rand() + rand() - 1.5;
  printf "{\"y\": {\"value\": %.17g, \"unit\": \"mm\"}, \"z\": %.17g}\n", 10 * a + b * b + 0.2 * n, b }' > out.json
)sh";

constexpr const char* study_text = R"toml([study]
name = "program"
seed = 1
[budget]
runs = 24
[[experiments]]
name = "user"
program = ["sh", "simulate.sh", "x", "FOLDER"]
template = "input.txt"
responses = "out.json"
[[parameters]]
name = "a"
min = 0
max = 1
[[parameters]]
name = "b"
min = 0.5
max = 2
[[targets]]
response = "y"
value = "6 mm"
uncertainty = "0.2 mm"
[[targets]]
response = "z"
value = 1
uncertainty = 0.05
)toml";

constexpr const char* few_runs =
    "center_replicates = 2\ndesign_points = 3\nreplicates_per_point = 1\n"
    "confirmation_replicates = 2\nrefine_rounds = 0";

using test::replaced;

class UserProgramTest : public testing::Test {
 protected:
  UserProgramTest() {
    write_simulator("");
    folder.write("input.txt", "a={{a}}\nb={{ b }}\nseed={{seed}}\n");
    write_study(study_text);
  }
  void write_simulator(const std::string& special) {
    folder.write("simulate.sh", replaced(simulator, "SPECIAL", special));
  }
  void write_study(const std::string& text) {
    folder.write("study.toml", replaced(text, "FOLDER", folder.path().string()));
  }
  StudyOptions options() const {
    StudyOptions o;
    o.study_file = folder / "study.toml";
    o.directory = folder / "out";
    o.allow_programs = true;
    o.show_progress = o.plot = false;
    o.jobs = 2;
    return o;
  }
  int count() const {
    const std::string text = read_own_file(folder / "count");  // empty before the first run
    return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  }
  // Empty: the study was read.
  std::string message(const std::string& text, Programs programs = Programs::allowed) {
    write_study(text);
    return test::error_if_any([&] { read_study(folder / "study.toml", programs); });
  }

  Folder folder{"program"};
};

TEST_F(UserProgramTest, GetsAChoiceAsText) {
  const std::string law = "[[parameters]]\nname = \"law\"\nchoices = [\"plain\", \"two words\"]\n";
  EXPECT_THAT(message(study_text + law), HasSubstr("{{law}} occurs neither in the template nor"));
  folder.write("input.txt", "a={{a}}\nb={{ b }}\nseed={{seed}}\nlaw='{{law}}'\n");
  // With two words y is 20 mm at least.
  write_simulator("[ \"$law\" != \"two words\" ] || a=$(awk -v a=\"$a\" 'BEGIN { print a + 2 }')");
  write_study(replaced(study_text, "runs = 24", "runs = 48") + law);
  const StudySummary s = calibrate(options());
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  const json choice = json::parse(s.json)["choice"];
  EXPECT_EQ(choice["best"], "plain");
  EXPECT_GT(choice["choices"][0]["probability"], 0.99);
  EXPECT_EQ(choice["choices"][1]["choice"], "two words");
  EXPECT_EQ(choice["choices"][1]["verdict"], "infeasible");
  EXPECT_LE(count(), 48);
  EXPECT_EQ(calibrate(options()).json, s.json);
}

// Study and program may spell one unit differently; another unit is refused.
TEST_F(UserProgramTest, SpellingsOfAUnitAreOneUnit) {
  const auto answer_in = [&](const std::string& unit) {
    write_simulator("");
    folder.write("simulate.sh", replaced(read_text(folder / "simulate.sh"), R"(\"mm\")",
                                         R"(\")" + unit + R"(\")"));
  };
  const std::string text = replaced(study_text, "runs = 24", few_runs);
  const std::pair<std::string, std::string> spellings[] = {
      {"m^3", "m³"}, {"m³", "m³"}, {"m³", "m^3"}, {"N m", "N·m"}, {"s^-1", "s⁻¹"}};
  for (const auto& [in_study, in_program] : spellings) {
    answer_in(in_program);
    write_study(replaced(replaced(text, "\"6 mm\"", "\"6 " + in_study + '"'), "\"0.2 mm\"",
                         "\"0.2 " + in_study + '"'));
    StudyOptions o = options();
    o.directory = folder / ("out " + in_study + in_program);
    EXPECT_NO_THROW(calibrate(o)) << in_study << " and " << in_program;
  }
  answer_in("m²");
  write_study(text);
  EXPECT_THROW(calibrate(options()), InputError);
}

TEST_F(UserProgramTest, FindsItsParametersAndRepeatsNothing) {
  const StudySummary s = calibrate(options());
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  const json j = json::parse(s.json);
  const double truth[] = {0.5, 1.0};
  for (std::size_t i = 0; i < 2; ++i) {
    const json& p = j["parameters"][i];
    EXPECT_LT(p["interval_95"][0], truth[i]);
    EXPECT_GT(p["interval_95"][1], truth[i]);
  }
  const int runs = count();
  EXPECT_EQ(runs, j["runs"]["total"].get<int>());
  EXPECT_LE(runs, 24);
  // The same folder again, and another folder with one job at a time: the same bits.
  EXPECT_EQ(calibrate(options()).json, s.json);
  EXPECT_EQ(count(), runs);
  StudyOptions other = options();
  other.directory = folder / "other";
  other.jobs = 1;
  json again = json::parse(calibrate(other).json), first = j;
  EXPECT_EQ(again["parameters"], first["parameters"]);
  EXPECT_EQ(again["estimate"], first["estimate"]);
  EXPECT_EQ(count(), 2 * runs);
}

TEST_F(UserProgramTest, KnowsRunsByContent) {
  StudyOptions o = options();
  o.store = folder / "store.db";
  calibrate(o);
  const int runs = count();
  const auto runs_again = [&](const std::string& directory) {
    const int before = count();
    o.directory = folder / directory;
    calibrate(o);
    return count() - before;
  };
  EXPECT_EQ(runs_again("copy"), 0);
  write_simulator("# another content");
  EXPECT_EQ(runs_again("program"), runs);
  folder.write("input.txt", "a={{a}}\nb={{b}}\n\nseed={{seed}}\n");
  EXPECT_EQ(runs_again("template"), runs);
}

TEST_F(UserProgramTest, FailuresAreRunsWithTheirLastLines) {
  write_simulator(
      "case $a in 0.8*|0.9*|1) echo before; echo 'no seed' >&2; echo diverged >&2; exit 3;; esac");
  const StudySummary s = calibrate(options());
  const json j = json::parse(s.json);
  EXPECT_GT(j["runs"]["failed"].get<int>(), 0) << s.table;
  EXPECT_EQ(s.exit_status(), 0) << s.table;
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr("exit status 3: no seed | diverged"));
}

TEST_F(UserProgramTest, ResponsesThatCannotBeReadFailTheRun) {
  for (const auto& [text, words] : {std::pair<std::string, std::string>{"true", "out.json"},
                                    {"echo '{' > out.json; exit 0", "JSON"},
                                    {"echo '[1]' > out.json; exit 0", "no JSON object"},
                                    {"echo '{\"y\": \"high\"}' > out.json; exit 0", "y"},
                                    {"echo '{\"y\": 1e999}' > out.json; exit 0", "out.json"}}) {
    folder.write("simulate.sh", text + "\n");
    StudyOptions o = options();
    o.directory = folder / ("out" + words);
    const StudySummary s = calibrate(o);
    EXPECT_EQ(s.verdict, StudyVerdict::too_few_runs) << text;
    EXPECT_EQ(s.exit_status(), 1);
    EXPECT_THAT(read_text(o.directory + "/runs.csv"), AllOf(HasSubstr("failed"), HasSubstr(words)));
  }
}

TEST_F(UserProgramTest, ReadsTablesAndUndefinedValues) {
  const std::string file = folder.write("r.csv", "response,value,unit\ny,2.5,mm\nz,,\n");
  const std::vector<Response> table = read_program_responses(file);
  ASSERT_EQ(table.size(), 2u);
  EXPECT_EQ(table[0].name, "y");
  EXPECT_EQ(table[0].value[0], 2.5);
  EXPECT_EQ(table[0].unit, "mm");
  EXPECT_TRUE(std::isnan(table[1].value[0]));
  EXPECT_EQ(table[1].unit, "1");
  const auto object = read_program_responses(folder.write(
      "r.json", R"({"y": {"value": 3, "unit": "deg", "uncertainty": 0.5}, "z": null})"));
  EXPECT_EQ(object[0].uncertainty, std::vector<double>{0.5});
  EXPECT_TRUE(std::isnan(object[1].value[0]));
  for (const char* bad : {R"({"": 1})", R"({"y": 1, "y": 2})", R"({"y": {"unit": "m"}})",
                          R"({"y": [1]})", R"({"y": true})", R"({"a\u0007": 1})"})
    EXPECT_THROW(read_program_responses(folder.write("bad.json", bad)), InputError) << bad;
}

TEST_F(UserProgramTest, LimitsEndTheProgramAndItsChildren) {
  write_simulator("trap '' TERM; sleep 321.5 & echo $! >> \"$2/children\"; wait; sleep 321.5");
  write_study(replaced(study_text, "runs = 24", few_runs));
  StudyOptions o = options();
  o.time_limit = 0.3;
  o.jobs = 5;
  const StudySummary s = calibrate(o);
  EXPECT_EQ(s.verdict, StudyVerdict::too_few_runs);
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr("over its limit of 0.3 s"));
  std::istringstream children(read_text(folder / "children"));
  int seen = 0;
  for (pid_t pid = 0; children >> pid; ++seen) {
    const std::string command = read_own_file("/proc/" + std::to_string(pid) + "/cmdline");
    EXPECT_EQ(command.find("321.5"), std::string::npos) << pid;
  }
  EXPECT_GE(seen, 5);
}

// The program itself stays small: each of its three children takes 70 MB.
TEST_F(UserProgramTest, TheLimitOfMemoryHoldsForAllProcesses) {
  write_simulator(
      "for i in 1 2 3; do head -c 70000000 /dev/zero | tail -c 70000000 | sleep 20 & done; wait");
  write_study(replaced(study_text, "runs = 24", few_runs));
  StudyOptions o = options();
  o.memory_limit = 160.0 * (1 << 20);
  EXPECT_EQ(calibrate(o).verdict, StudyVerdict::too_few_runs);
  EXPECT_THAT(read_text(folder / "out/runs.csv"), HasSubstr("over its limit of 160 MiB"));
}

TEST_F(UserProgramTest, AnInterruptedStudyGoesOn) {
  write_simulator("sleep 0.05");
  const StudySummary whole = [&] {
    StudyOptions o = options();
    o.directory = folder / "whole";
    return calibrate(o);
  }();
  const int runs = count();
  std::atomic<bool> stop{false};
  StudyOptions o = options();
  o.interrupt = &stop;
  std::thread timer([&] {
    while (count() < runs + 5) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    stop = true;
  });
  EXPECT_EQ(calibrate(o).verdict, StudyVerdict::interrupted);
  timer.join();
  EXPECT_LT(count(), 2 * runs);
  stop = false;
  o.resume = true;
  const json resumed = json::parse(calibrate(o).json), first = json::parse(whole.json);
  EXPECT_EQ(resumed["parameters"], first["parameters"]);
  EXPECT_LE(count(), 2 * runs + 2);  // those under way began again
}

// A cluster of scripts: sbatch carries out the tasks of the array at once.
TEST_F(UserProgramTest, RunsAsTasksOfSlurm) {
  fs::create_directory(folder / "bin");
  const auto command = [&](const std::string& name, const std::string& script) {
    fs::permissions(folder.write("bin/" + name, "#!/bin/sh\n" + script), fs::perms::owner_all);
  };
  command("squeue", "exit 0\n");
  command("sacct", "exit 1\n");
  command("scancel", "exit 0\n");
  command("sbatch", replaced(R"sh(for argument in "$@"; do
  case $argument in
    --job-name=*) list=FOLDER/out/slurm/${argument#*=}.json ;;
  esac
done
count=$(grep -c '"key"' $list)
index=0
while [ $index -lt $count ]; do
  )sh" FIRN_PROGRAM R"sh( slurm-task $list $index >&2 || exit 1
  index=$((index + 1))
done
echo 77
)sh",
                             "FOLDER", folder.path().string()));
  write_study(std::string(study_text) + "[execution.slurm]\npoll = \"0.05 s\"\n");
  StudyOptions o = options();
  o.executor = "slurm";
  const json by_slurm = [&] {
    const test::EnvironmentVariable path("PATH", (folder / "bin") + ":" + std::getenv("PATH"));
    return json::parse(calibrate(o).json);
  }();
  o.executor = "local";
  o.directory = folder / "local";
  const json here = json::parse(calibrate(o).json);
  EXPECT_EQ(by_slurm["verdict"], "calibrated");
  EXPECT_EQ(by_slurm["parameters"], here["parameters"]);
}

TEST_F(UserProgramTest, MistakesHaveAPlace) {
  const std::string text = study_text;
  const std::string program = "program = [\"sh\", \"simulate.sh\", \"x\", \"FOLDER\"]";
  EXPECT_THAT(
      message(text, Programs::refused),
      AllOf(HasSubstr("study.toml:8: experiments.user.program: "), HasSubstr("--allow-programs")));
  EXPECT_EQ(message(text), "");
  EXPECT_THAT(message(replaced(text, program, "program = [] # FOLDER")), HasSubstr("no list"));
  EXPECT_THAT(message(replaced(text, "\"sh\"", "\"no-such-program\"")),
              HasSubstr("\"no-such-program\" is not a program that can be started"));
  EXPECT_THAT(message(replaced(text, "\"sh\", ", "\"./missing\", ")), HasSubstr("can be started"));
  EXPECT_THAT(message(replaced(text, "out.json", "../out.json")),
              HasSubstr("is not the name of a file of responses"));
  EXPECT_THAT(message(replaced(text, "out.json", "out.txt")),
              HasSubstr("is not the name of a file of responses"));
  EXPECT_THAT(message(replaced(text, "\"input.txt\"", "\"none.txt\"")), HasSubstr("none.txt"));
  EXPECT_THAT(message(replaced(text, "responses =", "inputs = [\"none\"]\nresponses =")),
              HasSubstr("none"));
  EXPECT_THAT(message(replaced(text, "responses =", "case = \"case.toml\"\nresponses =")),
              HasSubstr("case"));
  EXPECT_THAT(message(replaced(text, "\"x\"", "\"{{c}}\"")),
              HasSubstr("{{c}} is neither a parameter"));
  EXPECT_THAT(message(replaced(text, "responses =", "set = { dt = 1 }\nresponses =")),
              HasSubstr("{{dt}} occurs neither"));
  EXPECT_THAT(message(replaced(text, "[[targets]]",
                               "[[numerics]]\nname = \"n\"\nset = { dt = 1 }\n[[targets]]")),
              HasSubstr("\"dt\" is not a key of `set`"));
  folder.write("input.txt", "a={{a}}\n\nb={{bb}}\n");
  EXPECT_THAT(message(text), HasSubstr("input.txt:3: {{bb}} is neither a parameter"));
  folder.write("input.txt", "a={{a}} {{ {b} }}\n");
  EXPECT_THAT(message(text), HasSubstr("{{b}} occurs neither"));
  folder.write("input.txt", "a={{a}} b={{b}} \xff\n");
  EXPECT_THAT(message(text), HasSubstr("no UTF-8"));
}

// The shipped study of LIGGGHTS finds the friction that made its target.
TEST(UserProgramLong, CalibratesLiggghts) {
  if (!fs::exists("/usr/bin/liggghts")) GTEST_SKIP() << "liggghts is not installed";
  const Folder folder("liggghts");
  StudyOptions o;
  o.study_file = std::string(FIRN_SOURCE_DIR) + "/cases/liggghts/study.toml";
  o.directory = folder / "out";
  o.allow_programs = true;
  o.show_progress = o.plot = false;
  const StudySummary s = calibrate(o);
  const json j = json::parse(s.json);
  EXPECT_EQ(s.verdict, StudyVerdict::calibrated) << s.table;
  EXPECT_EQ(j["runs"]["finished"], j["runs"]["total"]) << s.table;
  EXPECT_LT(j["parameters"][0]["interval_95"][0].get<double>(), 0.4) << s.table;
  EXPECT_GT(j["parameters"][0]["interval_95"][1].get<double>(), 0.4) << s.table;
}

// Whatever stands around placeholders stays, and a value is one word of the arguments.
TEST(UserProgram, TemplatesKeepTheirText) {
  std::mt19937_64 random(5);
  const std::string letters = "{}a \n\"$`;|";
  for (int i = 0; i < 2000; ++i) {
    UserProgram p;
    std::string before, after;
    for (std::string* part : {&before, &after})
      for (int n = static_cast<int>(random() % 12); n > 0; --n)
        *part += letters[random() % letters.size()];
    // Braces that join with those of the placeholder, and names by chance, are not the subject.
    while (!before.empty() && before.back() == '{') before.pop_back();
    while (!after.empty() && after.front() == '}') after.erase(0, 1);
    const auto names = [](const std::string& text) { return text.find("}}") != text.npos; };
    if (names(before) || names(after)) continue;
    if (before.find("{{") != before.npos && before.find('\n', before.rfind("{{")) == before.npos)
      before += '\n';
    p.arguments = {"program", "--x={{ x }}"};
    p.template_text = before + "{{x}}" + after;
    const ProgramRun run = program_run(p, {{"x", "1 ; {{x}} $(rm)"}});
    EXPECT_EQ(run.input_text, before + "1 ; {{x}} $(rm)" + after);
    EXPECT_EQ(run.arguments, (std::vector<std::string>{"program", "--x=1 ; {{x}} $(rm)"}));
  }
}

}  // namespace
}  // namespace firn
