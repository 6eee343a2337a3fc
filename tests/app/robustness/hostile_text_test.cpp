// Hostile text in every field of every input, through every command: it is refused in one line or
// shown as text, and never executed.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "experiments/storage/sqlite_file.h"
#include "experiments/system/process.h"
#include "experiments/system/text_encoding.h"
#include "tests/app/program.h"
#include "tests/app/robustness/hostile_inputs.h"

namespace firn::cli {
namespace {

using namespace hostile;
using nlohmann::json;
namespace fs = std::filesystem;

// A folder with all inputs, and the files that commands must not make.
class Site : public Folder {
 public:
  Site() {
    canary_ = path() / "CANARY";
    setenv("CANARY", canary_.c_str(), 1);
    setenv("FIRN_MATERIALS", (path() / "own.db").c_str(), 1);
    write("case.toml", rich_case);
    write("sweep.toml", sweep_file);
    write("optimization.toml", optimization_file);
    write("study.toml", study_file);
    write("suite.toml", suite_file);
    write("mass.toml", mass_file);
    write("claims.toml", claims_file);
    write("record.json", record_file);
    write("check.py", checker);
    outside_ = entries(path().parent_path());
  }

  // Runs a command; its status must be 0 or 2, and its output text in lines. Returns the status.
  int run(const std::vector<std::string>& arguments, const std::string& what) {
    const Outcome o = firn(arguments);
    if (o.status != 0) last_error_ = o.err;
    const std::string context = arguments[0] + " with " + encode::terminal(what).substr(0, 300) +
                                "\n" + encode::terminal_lines(o.err).substr(0, 500);
    EXPECT_TRUE(o.status == 0 || o.status == 2) << o.status << ": " << context;
    if (o.status == 2) {
      EXPECT_EQ(lines(o.err), 1u) << context;
    }
    for (const std::string& text : {o.out, o.err})
      EXPECT_EQ(encode::terminal_lines(text), text) << context;
    EXPECT_FALSE(fs::exists(canary_)) << context;
    fs::remove(canary_);
    return o.status;
  }

  const std::string& last_error() const { return last_error_; }

  // No file of the program lies outside its folder.
  void expect_nothing_outside() const {
    for (const std::string& name : entries(path().parent_path())) {
      const bool ours = name.starts_with("escaped") || name == "runs.csv" || name == "study.db";
      EXPECT_TRUE(!ours || std::ranges::find(outside_, name) != outside_.end()) << name;
    }
    EXPECT_FALSE(fs::exists("/absolute"));
  }

  // Parses what was written with a reader of its kind.
  void expect_encoded(const std::vector<std::string>& files) const {
    std::vector<std::string> command = {"python3", "check.py"};
    for (const std::string& file : files)
      if (fs::exists(path() / file)) command.push_back(file);
    ASSERT_GT(command.size(), 2u);
    const CommandResult r = run_command(command, path().string());
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.out, "");
  }

 private:
  static std::vector<std::string> entries(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
    return names;
  }
  fs::path canary_;
  std::string last_error_;
  std::vector<std::string> outside_;
};

// ---- TOML: every string and every key

std::string text_of(const toml::table& table) {
  std::ostringstream out;
  out << toml::toml_formatter(table, toml::toml_formatter::default_flags &
                                         ~toml::format_flags::allow_literal_strings)
      << '\n';
  return out.str();
}

// Calls f(node) for every string of a document, in order.
void for_strings(toml::node& node, const std::function<void(toml::value<std::string>&)>& f) {
  if (toml::table* table = node.as_table())
    for (auto&& [key, value] : *table) for_strings(value, f);
  if (toml::array* array = node.as_array())
    for (toml::node& value : *array) for_strings(value, f);
  if (auto* text = node.as_string()) f(*text);
}

// Calls f(table, key) for every key of a document; f may not change the document.
void for_keys(toml::node& node, const std::function<void(toml::table&, std::string)>& f) {
  if (toml::table* table = node.as_table())
    for (auto&& [key, value] : *table) {
      f(*table, std::string(key.str()));
      for_keys(value, f);
    }
  if (toml::array* array = node.as_array())
    for (toml::node& value : *array) for_keys(value, f);
}

// Every document that differs from `base` in one string or key. `texts(i)`: what replaces field i.
std::vector<std::pair<std::string, std::string>> changed_toml(
    const std::string& base, const std::function<std::vector<std::string>(std::size_t)>& texts) {
  std::vector<std::pair<std::string, std::string>> documents;  // what was put in, text
  toml::table original = toml::parse(base);
  std::size_t strings = 0, keys = 0;
  for_strings(original, [&](toml::value<std::string>&) { ++strings; });
  for_keys(original, [&](toml::table&, const std::string&) { ++keys; });
  for (std::size_t field = 0; field < strings; ++field)
    for (const std::string& text : texts(field)) {
      toml::table document = toml::parse(base);
      std::size_t k = 0;
      std::string old;
      for_strings(document, [&](toml::value<std::string>& value) {
        if (k++ != field) return;
        old = value.get();
        value = text;
      });
      documents.emplace_back(old + " -> " + text, text_of(document));
    }
  for (std::size_t field = 0; field < keys; ++field)
    for (const std::string& text : texts(strings + field)) {
      toml::table document = toml::parse(base);
      toml::table* owner = nullptr;
      std::string old;
      std::size_t k = 0;
      for_keys(document, [&](toml::table& table, const std::string& key) {
        if (k++ == field) owner = &table, old = key;
      });
      toml::table value;
      value.insert_or_assign("v", *owner->get(old));
      owner->erase(old);
      owner->insert_or_assign(text, *value.get("v"));
      documents.emplace_back("key " + old + " -> " + text, text_of(document));
    }
  return documents;
}

// A few texts a field, others for the next field.
std::function<std::vector<std::string>(std::size_t)> some_texts(std::size_t count) {
  return [count](std::size_t field) {
    const std::vector<std::string> all = all_texts();
    std::mt19937 random(static_cast<unsigned>(field));
    std::vector<std::string> some;
    for (std::size_t k = 0; k < count; ++k)
      some.push_back(all[(field * count + k + random() % 3) % all.size()]);
    return some;
  };
}

// Puts a text into one field after the other, and runs commands on what comes of it.
class Fields {
 public:
  // `texts`: how many a field.
  explicit Fields(std::size_t texts) : texts_(some_texts(texts)), count_(texts) {}

  void cases() {
    for (const auto& [what, text] : changed_toml(rich_case, texts_)) {
      site_.write("case.toml", text);
      if (site_.run({"shape", "case.toml"}, what) != 0) continue;
      if (site_.run({"run", "-q", "case.toml", "-o", "x.h5"}, what) != 0) continue;
      results(what);
      if (what.starts_with("rich -> ")) site_.run({"run", "-q", "case.toml"}, what);
    }
    finish();
  }
  void batches(const char* command, const std::string& file, const char* base,
               const std::string& started) {
    for (const auto& [what, text] : changed_toml(base, texts_)) {
      site_.write(file, text);
      if (site_.run({command, started, "--progress", "none"}, what) == 0)
        site_.run({command, started, "--progress", "text"}, what);
      fs::remove_all(site_.path() / "runs");
    }
    finish();
  }
  void records() {
    const json base = json::parse(record_file);
    const json flat = base.flatten();
    std::size_t field = 0;
    for (const auto& [pointer, value] : flat.items()) {
      if (!value.is_string()) continue;
      for (const std::string& text : texts_(field++)) {
        json changed = base;
        changed[json::json_pointer(pointer)] = text;
        site_.write("x.json", changed.dump(-1, ' ', false, json::error_handler_t::ignore));
        if (site_.run({"materials", "add", "x.json"}, pointer + " " + text) != 0) continue;
        for (const char* all : {"list", "export", "verify"})
          site_.run(all == std::string("export")
                        ? std::vector<std::string>{"materials", all, "--all"}
                        : std::vector<std::string>{"materials", all},
                    pointer + " " + text);
        site_.run({"materials", "show", "mine"}, pointer + " " + text);
        fs::remove(site_.path() / "own.db");
      }
    }
    EXPECT_GT(field, 10u);
    finish();
  }
  // Strings of results.json, as of a study or a validation, shown as a page.
  void pages(const char* command, const std::string& file, const std::string& folder) {
    ASSERT_EQ(site_.run({command, file, "-o", folder, "--progress", "none"}, "no change"), 0);
    const fs::path results = site_.path() / folder / "results.json";
    const json base = json::parse(read_text(results));
    ASSERT_EQ(site_.run({"report", folder, "-o", "benign.html", "--no-replays"}, "no change"), 0);
    std::vector<std::string> pages;
    std::size_t field = 0;
    const json flat = base.flatten();
    for (const auto& [pointer, value] : flat.items()) {
      if (!value.is_string()) continue;
      for (const std::string& text : texts_(field++)) {
        json changed = base;
        changed[json::json_pointer(pointer)] = text;
        std::ofstream(results) << changed.dump(-1, ' ', false, json::error_handler_t::replace);
        const std::string page = "page" + std::to_string(pages.size()) + ".html";
        if (site_.run({"report", folder, "-o", page, "--no-replays"}, pointer + " " + text) != 0)
          continue;
        fs::copy(site_.path() / "benign.html", site_.path() / (page + ".benign"));
        pages.push_back(page);
      }
    }
    EXPECT_GT(field, 5u);
    site_.expect_encoded(pages);
    finish();
  }
  // Text columns of the study's database: the next command reads them all.
  void databases() {
    ASSERT_EQ(site_.run({"calibrate", "study.toml", "-o", "out", "--progress", "none"}, ""), 0);
    fs::copy(site_.path() / "out", site_.path() / "base", fs::copy_options::recursive);
    std::vector<std::pair<std::string, std::string>> columns;
    {
      sqlite::File db((site_.path() / "base/study.db").string(), sqlite::File::Access::read);
      sqlite::Statement tables(db,
                               "SELECT m.name, c.name FROM sqlite_master m, "
                               "pragma_table_info(m.name) c WHERE m.type = 'table' AND "
                               "c.type LIKE '%TEXT%'");
      while (tables.next()) columns.emplace_back(tables.text(0), tables.text(1));
    }
    ASSERT_GT(columns.size(), 5u);
    for (std::size_t field = 0; field < columns.size(); ++field)
      for (const std::string& text : texts_(field)) {
        fs::remove_all(site_.path() / "out");
        fs::copy(site_.path() / "base", site_.path() / "out", fs::copy_options::recursive);
        std::string hex;
        for (const char c : text) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
        {
          sqlite::File db((site_.path() / "out/study.db").string(), sqlite::File::Access::write);
          try {
            db.execute(fmt::format("UPDATE {} SET {} = CAST(X'{}' AS TEXT)", columns[field].first,
                                   columns[field].second, hex)
                           .c_str());
          } catch (const std::exception&) {
            continue;  // a key that must be different in each row
          }
        }
        const std::string what = columns[field].first + "." + columns[field].second + " " + text;
        site_.run({"calibrate", "study.toml", "-o", "out", "--progress", "none"}, what);
      }
    site_.expect_encoded({"out/runs.csv", "out/report.md", "out/fitted_response.svg"});
    finish();
  }
  // Attributes, names of datasets and strings of a results file.
  void results_files();

 private:
  void results(const std::string& what) {
    site_.run({"measure", "x.h5"}, what);
    site_.run({"export", "x.h5", "--to", "csv", "-o", "csv"}, what);
    site_.run({"export", "x.h5", "--to", "vtk", "-o", "vtk"}, what);
    site_.run({"report", "x.h5", "-o", "x.html"}, what);
  }
  void finish() { site_.expect_nothing_outside(); }

  Site site_;
  std::function<std::vector<std::string>(std::size_t)> texts_;
  std::size_t count_;
};

// ---- results files, changed through HDF5

// Every place of text in a file: (object, attribute), or (dataset, "").
using Places = std::vector<std::pair<std::string, std::string>>;

bool is_text(hid_t type) {
  const bool text = H5Tget_class(type) == H5T_STRING;
  H5Tclose(type);
  return text;
}

herr_t add_attribute(hid_t object, const char* name, const H5A_info_t*, void* data) {
  auto& [path, places] = *static_cast<std::pair<std::string, Places*>*>(data);
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  if (is_text(H5Aget_type(attribute))) places->emplace_back(path, name);
  H5Aclose(attribute);
  return 0;
}

herr_t add_object(hid_t file, const char* name, const H5O_info_t* info, void* data) {
  auto* places = static_cast<Places*>(data);
  const hid_t object = H5Oopen(file, name, H5P_DEFAULT);
  std::pair<std::string, Places*> of{name, places};
  H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, add_attribute, &of);
  if (info->type == H5O_TYPE_DATASET && is_text(H5Dget_type(object)))
    places->emplace_back(name, "");
  H5Oclose(object);
  return 0;
}

Places places_of_text(const fs::path& results) {
  Places places;
  const hid_t file = H5Fopen(results.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, add_object, &places, H5O_INFO_BASIC);
  H5Fclose(file);
  return places;
}

std::string read_attribute(const fs::path& results, const std::string& name) {
  const hid_t file = H5Fopen(results.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t attribute = H5Aopen(file, name.c_str(), H5P_DEFAULT), type = H5Aget_type(attribute);
  char* text = nullptr;
  H5Aread(attribute, type, &text);
  const std::string result = text;
  H5free_memory(text);
  H5Tclose(type), H5Aclose(attribute), H5Fclose(file);
  return result;
}

void put_text(const fs::path& results, const std::string& path, const std::string& attribute,
              const std::string& text) {
  const hid_t file = H5Fopen(results.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t object = H5Oopen(file, path.c_str(), H5P_DEFAULT);
  if (attribute.empty()) {
    const hid_t type = H5Dget_type(object), space = H5Dget_space(object);
    const auto count = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
    const std::vector<const char*> texts(count, text.c_str());
    H5Dwrite(object, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data());
    H5Tclose(type), H5Sclose(space);
  } else {
    const hid_t opened = H5Aopen(object, attribute.c_str(), H5P_DEFAULT);
    const hid_t type = H5Aget_type(opened);
    const char* pointer = text.c_str();
    H5Awrite(opened, type, &pointer);
    H5Tclose(type), H5Aclose(opened);
  }
  H5Oclose(object), H5Fclose(file);
}

void Fields::results_files() {
  const fs::path base = site_.path() / "base.h5", changed = site_.path() / "x.h5";
  ASSERT_EQ(site_.run({"run", "-q", "case.toml", "-o", "base.h5"}, ""), 0);
  const std::vector<std::vector<std::string>> commands = {
      {"measure", "x.h5"},
      {"report", "x.h5", "-o", "x.html"},
      {"export", "x.h5", "--to", "csv", "-o", "csv"},
      {"export", "x.h5", "--to", "vtk", "-o", "vtk"},
      {"contacts", "x.h5"},
      {"contacts", "x.h5", "--particle", "0", "-o", "contacts.csv"},
      {"run", "-q", "--resume", "x.h5"}};
  std::size_t next = 0;
  const auto try_file = [&](const std::string& what) {
    for (std::size_t k = 0; k < std::min<std::size_t>(count_, 3); ++k)
      site_.run(commands[next++ % commands.size()], what);
  };
  const Places places = places_of_text(base);
  ASSERT_GT(places.size(), 20u);
  for (std::size_t field = 0; field < places.size(); ++field)
    for (const std::string& text : texts_(field)) {
      fs::copy_file(base, changed, fs::copy_options::overwrite_existing);
      put_text(changed, places[field].first, places[field].second, text);
      try_file(places[field].first + ":" + places[field].second + " " + text);
    }
  // Inside the case that a file holds: its names alone, the rest is a case like any other.
  const std::string held = read_attribute(base, "case");
  for (const char* name : {"rich", "floor", "panel", "arm", "half way", "away", "settle", "hold",
                           "press", "bridge", "cube"})
    for (const std::string& text : texts_(next)) {
      toml::table document = toml::parse(held);
      for_strings(document, [&](toml::value<std::string>& value) {
        if (value.get() == name) value = text;
      });
      fs::copy_file(base, changed, fs::copy_options::overwrite_existing);
      put_text(changed, "/", "case", text_of(document));
      try_file(std::string("case: ") + name + " -> " + text);
    }
  finish();
}

// ---- all names at once, through everything that shows them

// Gives everything named `old` another name: strings, keys and pairs of materials.
std::string renamed(const std::string& base, const std::map<std::string, std::string>& names) {
  toml::table document = toml::parse(base);
  for_strings(document, [&](toml::value<std::string>& value) {
    if (const auto found = names.find(value.get()); found != names.end()) value = found->second;
  });
  for (bool again = true; again;) {
    toml::table* owner = nullptr;
    std::string old;
    for_keys(document, [&](toml::table& table, const std::string& key) {
      if (names.contains(key)) owner = &table, old = key;
    });
    again = owner != nullptr;
    if (!again) break;
    toml::table value;
    value.insert_or_assign("v", *owner->get(old));
    owner->erase(old);
    owner->insert_or_assign(names.at(old), *value.get("v"));
  }
  return text_of(document);
}

// Runs the whole way from cases to pages and tables; names of outputs begin with `to`.
void run_all_commands(Site& site, const std::string& to, const std::string& text, bool draw) {
  site.run({"run", "-q", "case.toml", "-o", to + ".h5"}, text);
  site.run({"shape", "case.toml"}, text);
  site.run({"measure", to + ".h5"}, text);
  site.run({"report", to + ".h5", "-o", to + ".html", "--figures", to + "-figures"}, text);
  site.run({"export", to + ".h5", "--to", "csv", "-o", to + "-csv"}, text);
  site.run({"export", to + ".h5", "--to", "vtk", "-o", to + "-vtk"}, text);
  site.run({"contacts", to + ".h5", "--particle", "0", "-o", to + "-contacts.csv"}, text);
  site.run({"contacts", to + ".h5", "--particle", "0", "--history", "0 s", "2 ms", "-o",
            to + "-history.svg"},
           text);
  const std::map<std::string, std::string> batches = {
      {"sweep", "sweep.toml"}, {"calibrate", "study.toml"}, {"validate", "suite.toml"}};
  for (const auto& [command, file] : batches)
    site.run({command, file, "-o", to + "-" + command, "--progress", "text"}, text);
  site.run({"report", to + "-calibrate", "-o", to + "-study.html"}, text);
  site.run({"report", to + "-validate", "-o", to + "-suite.html"}, text);
  if (!draw) return;
  site.run({"shape", "case.toml", "--picture", to + "-shape.svg"}, text);
  site.run({"contacts", to + ".h5", "--particle", "0", "-o", to + "-contacts.svg"}, text);
}

// The pages that the unchanged files give; made once.
const std::map<std::string, std::string>& benign_pages() {
  static const auto pages = [] {
    Site site;
    run_all_commands(site, "benign", "no change", false);
    std::map<std::string, std::string> made;
    for (const char* page : {"", "-study", "-suite"})
      made[page] = read_text(site.path() / ("benign" + std::string(page) + ".html"));
    return made;
  }();
  return pages;
}

// Runs the whole way with one text in all names.
void go_through_everything(const std::string& text, bool pictures) {
  Site site;
  std::map<std::string, std::string> names;
  for (const char* name : {"rich", "floor", "panel", "arm", "half way", "away", "settle", "hold",
                           "press", "bridge", "cube"})
    names[name] = text + " " + std::to_string(names.size());
  site.write("case.toml", renamed(rich_case, names));
  names.clear();
  for (const char* name : {"boxes",           "density",
                           "study",           "rho",
                           "paper",           "finer",
                           "suite",           "All of it",
                           "a note",          "as it is",
                           "nothing changed", "fall",
                           "heavier",         "mass",
                           "The mass",        "of both",
                           "claims",          "mass of two boxes",
                           "a balance",       "what was seen",
                           "both stay",       "a notebook",
                           "they are two"})
    names[name] = text + " " + std::to_string(names.size());
  // Tables have these keys, too.
  std::map<std::string, std::string> in_sweep = names, in_study = names, in_suite = names;
  in_suite.erase("claims"), in_suite.erase("suite"), in_study.erase("study");
  const auto claims = [&](std::string base) {
    toml::table document = toml::parse(base);
    for_strings(document, [&](toml::value<std::string>& value) {
      if (names.contains(value.get())) value = names.at(value.get());
    });
    return text_of(document);
  };
  site.write("sweep.toml", renamed(sweep_file, in_sweep));
  site.write("study.toml", renamed(study_file, in_study));
  site.write("suite.toml", renamed(suite_file, in_suite));
  site.write("mass.toml", claims(mass_file));
  site.write("claims.toml", claims(claims_file));
  run_all_commands(site, "hostile", text, pictures);
  std::vector<std::string> files = {
      "hostile-contacts.csv",        "hostile-history.svg",
      "hostile-sweep/runs.csv",      "hostile-calibrate/runs.csv",
      "hostile-calibrate/report.md", "hostile-calibrate/fitted_response.svg",
      "hostile-shape.svg",           "hostile-contacts.svg"};
  for (const auto& folder : {"hostile-csv", "hostile-figures"})
    for (const auto& entry : fs::directory_iterator(site.path() / folder))
      files.push_back(std::string(folder) + "/" + entry.path().filename().string());
  for (const char* page : {"", "-study", "-suite"}) {
    const std::string file = std::string("hostile") + page + ".html";
    ASSERT_TRUE(site.contains(file)) << file << " with " << text << "\n" << site.last_error();
    site.write(file + ".benign", benign_pages().at(page));
    files.push_back(file);
  }
  for (const char* made : {"hostile-sweep/runs.csv", "hostile-calibrate/fitted_response.svg",
                           "hostile-history.svg", "hostile-csv/responses.csv"})
    EXPECT_TRUE(site.contains(made)) << made << " with " << text;
  site.expect_encoded(files);
  site.expect_nothing_outside();
}

TEST(HostileText, CasesAreRefusedOrShown) { Fields(1).cases(); }
TEST(HostileText, SweepsAreRefusedOrShown) {
  Fields(3).batches("sweep", "sweep.toml", sweep_file, "sweep.toml");
}
TEST(HostileText, OptimizationsAreRefusedOrShown) {
  Fields(1).batches("optimize", "optimization.toml", optimization_file, "optimization.toml");
}
TEST(HostileText, StudiesAreRefusedOrShown) {
  Fields(1).batches("calibrate", "study.toml", study_file, "study.toml");
}
TEST(HostileText, SuitesAreRefusedOrShown) {
  Fields(1).batches("validate", "suite.toml", suite_file, "suite.toml");
}
TEST(HostileText, MeasurementsAreRefusedOrShown) {
  Fields(1).batches("validate", "mass.toml", mass_file, "suite.toml");
  Fields(1).batches("validate", "claims.toml", claims_file, "suite.toml");
}
TEST(HostileText, RecordsAreRefusedOrShown) { Fields(3).records(); }
TEST(HostileText, ResultsFilesAreRefusedOrShown) { Fields(1).results_files(); }
TEST(HostileText, PagesShowIt) { Fields(1).pages("validate", "suite.toml", "out"); }
TEST(HostileText, PagesOfOptimizationsShowIt) {
  Fields(1).pages("optimize", "optimization.toml", "out");
}
TEST(HostileText, DatabasesAreRefusedOrShown) { Fields(1).databases(); }

TEST(HostileText, NamesGoThroughEverythingAsText) {
  const std::vector<std::string> texts = printable_names();
  for (const std::size_t k : {3u, 6u}) go_through_everything(texts[k], false);
  go_through_everything(texts[0], true);
}

// Calls f(table) for every table of a document.
void for_tables(toml::node& node, const std::function<void(toml::table&)>& f) {
  if (toml::table* table = node.as_table()) {
    f(*table);
    for (auto&& [key, value] : *table) for_tables(value, f);
  }
  if (toml::array* array = node.as_array())
    for (toml::node& value : *array) for_tables(value, f);
}

struct Input {
  const char *file, *text;
  std::vector<std::string> command;
};
std::vector<Input> inputs() {
  return {{"case.toml", rich_case, {"shape", "case.toml"}},
          {"sweep.toml", sweep_file, {"sweep", "sweep.toml"}},
          {"optimization.toml", optimization_file, {"optimize", "optimization.toml"}},
          {"study.toml", study_file, {"calibrate", "study.toml"}},
          {"suite.toml", suite_file, {"validate", "suite.toml"}},
          {"mass.toml", mass_file, {"validate", "suite.toml"}},
          {"claims.toml", claims_file, {"validate", "suite.toml"}}};
}

TEST(HostileText, NamesWithControlCharactersAreRefusedWithTheirPlace) {
  Site site;
  std::size_t fields = 0;
  for (const Input& input : inputs())
    for (const char* key : {"name", "title"}) {
      std::size_t count = 0;
      toml::table document = toml::parse(input.text);
      for_tables(document, [&](toml::table& table) { count += table.contains(key); });
      for (std::size_t field = 0; field < count; ++field)
        for (const char* text : {"a\nb", "a\rb", "\x1b[2Jb",
                                 "a\xe2\x80\xae"
                                 "b",
                                 "\xc2\x9b"}) {
          toml::table changed = toml::parse(input.text);
          std::size_t k = 0;
          for_tables(changed, [&](toml::table& table) {
            if (table.contains(key) && k++ == field) table.insert_or_assign(key, text);
          });
          site.write(input.file, text_of(changed));
          EXPECT_EQ(site.run(input.command, text), 2);
          EXPECT_NE(site.last_error().find(std::string(input.file) + ":"), std::string::npos);
          EXPECT_NE(site.last_error().find(std::string(key) + ": has the character \\"),
                    std::string::npos)
              << site.last_error();
          ++fields;
        }
      site.write(input.file, input.text);
    }
  EXPECT_GT(fields, 100u);
}

TEST(HostileText, NamesThatLeaveTheirFolderAreRefused) {
  Site site;
  const std::map<std::string, std::vector<std::string>> named = {
      {"sweep.toml", {"boxes", "density"}},
      {"optimization.toml", {"heavy boxes", "rho"}},
      {"study.toml", {"study", "rho"}},
      {"suite.toml", {"suite", "as it is", "fall", "heavier", "mass"}},
      {"case.toml", {"floor"}}};
  for (const Input& input : inputs()) {
    if (!named.contains(input.file)) continue;
    for (const std::string& name : named.at(input.file))
      for (const char* text : {".", "..", "../up", "/absolute", "a/b", "", "-rf"}) {
        std::string changed = input.text;
        const std::string line = "name = \"" + name + "\"";
        changed.replace(changed.find(line), line.size(), std::string("name = \"") + text + "\"");
        site.write(input.file, changed);
        EXPECT_EQ(site.run(input.command, text), 2) << name << " -> " << text;
        EXPECT_NE(site.last_error().find("name: is \""), std::string::npos) << site.last_error();
      }
    site.write(input.file, input.text);
  }
  site.expect_nothing_outside();
  EXPECT_FALSE(site.contains("runs"));
}

TEST(HostileText, PathsThatNoSystemTakesAreOneLine) {
  Site site;
  ASSERT_EQ(site.run({"run", "-q", "case.toml", "-o", "x.h5"}, ""), 0);
  for (const std::string& path :
       {std::string(5000, 'x'), std::string(254, 'x'), std::string("\xff")})
    for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
             {"run", "-q", path},
             {"run", "-q", "--resume", path + ".h5"},
             {"run", "-q", "case.toml", "-o", path + ".h5"},
             {"shape", path + ".stl"},
             {"shape", path + ".toml"},
             {"measure", path + ".h5"},
             {"export", path + ".h5", "--to", "csv"},
             {"export", "x.h5", "--to", "csv", "-o", path + "/a"},
             {"contacts", path + ".h5"},
             {"report", path},
             {"report", path + ".h5"},
             {"report", "x.h5", "-o", path + ".html", "--json"},
             {"calibrate", path},
             {"calibrate", "study.toml", "-o", path + "/b", "--progress", "none"},
             {"sweep", "sweep.toml", "-o", path + "/c", "--progress", "none"},
             {"validate", path},
             {"materials", "add", path},
             {"materials", "list", "--database", path}}) {
      site.run(command, path);
      EXPECT_EQ(site.last_error().find("filesystem error"), std::string::npos) << command[0];
    }
}

Fields all_texts_in_fields() { return Fields(all_texts().size()); }

TEST(HostileTextLong, EveryTextInCases) { all_texts_in_fields().cases(); }

TEST(HostileTextLong, EveryTextInSweeps) {
  all_texts_in_fields().batches("sweep", "sweep.toml", sweep_file, "sweep.toml");
}

TEST(HostileTextLong, EveryTextInOptimizations) {
  all_texts_in_fields().batches("optimize", "optimization.toml", optimization_file,
                                "optimization.toml");
}

TEST(HostileTextLong, EveryTextInStudies) {
  all_texts_in_fields().batches("calibrate", "study.toml", study_file, "study.toml");
}

TEST(HostileTextLong, EveryTextInSuites) {
  all_texts_in_fields().batches("validate", "suite.toml", suite_file, "suite.toml");
}

TEST(HostileTextLong, EveryTextInMeasurements) {
  all_texts_in_fields().batches("validate", "mass.toml", mass_file, "suite.toml");
}

TEST(HostileTextLong, EveryTextInClaims) {
  all_texts_in_fields().batches("validate", "claims.toml", claims_file, "suite.toml");
}

TEST(HostileTextLong, EveryTextInRecords) { all_texts_in_fields().records(); }

TEST(HostileTextLong, TextsInEveryResultsFile) { Fields(12).results_files(); }

TEST(HostileTextLong, EveryTextInEveryPageAndDatabase) {
  Fields(5).pages("validate", "suite.toml", "out");
  Fields(5).pages("calibrate", "study.toml", "out");
  Fields(all_texts().size()).databases();
}

TEST(HostileTextLong, EveryNameGoesThroughEverything) {
  for (const std::string& text : printable_names()) go_through_everything(text, true);
}

// The checks see what they are for.
TEST(HostileText, TheCheckerSeesWhatIsNotEncoded) {
  const Site site;
  site.write("a.html.benign", "<html><p>x</p><script>1</script></html>");
  for (const char* bad :
       {"<html><img src=x></html>", "<html><p onclick='x'>x</p><script>1</script></html>",
        "<html><p>x</p><script>1</script><script>alert(1)</script></html>"}) {
    site.write("a.html", bad);
    EXPECT_NE(run_command({"python3", "check.py", "a.html"}, site.path().string()).out, "") << bad;
  }
  site.write("a.csv", "a,b\n=1+1,2\n");
  EXPECT_NE(run_command({"python3", "check.py", "a.csv"}, site.path().string()).out, "");
  site.write("a.md", "# <img src=x>\n");
  EXPECT_NE(run_command({"python3", "check.py", "a.md"}, site.path().string()).out, "");
  site.write("a.svg", "<svg onload='x'><script/></svg>");
  EXPECT_NE(run_command({"python3", "check.py", "a.svg"}, site.path().string()).out, "");
}

}  // namespace
}  // namespace firn::cli
