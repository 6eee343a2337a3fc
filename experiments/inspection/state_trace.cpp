#include "experiments/inspection/state_trace.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include "experiments/case_reader/read_case.h"
#include "experiments/system/input_file.h"

namespace firn {
namespace {

constexpr std::string_view kMagic = "# firn trace 1";
constexpr std::string_view kCase = "# case ";
constexpr std::string_view kGroups = "# groups ";
constexpr std::string_view kStep = "step ";

class Line {
 public:
  explicit Line(const std::string& subject) : text_(subject) {}
  Line& add(const char* name, double value) {
    text_ += fmt::format(" {}={:a}", name, value);
    return *this;
  }
  Line& add(const char* name, const Vec3& v) {
    text_ += fmt::format(" {0}_x={1:a} {0}_y={2:a} {0}_z={3:a}", name, v.x(), v.y(), v.z());
    return *this;
  }
  Line& add(const char* name, const Quat& q) {
    text_ += fmt::format(" {0}_w={1:a} {0}_x={2:a} {0}_y={3:a} {0}_z={4:a}", name, q.w(), q.x(),
                         q.y(), q.z());
    return *this;
  }
  std::string text() const { return text_ + "\n"; }

 private:
  std::string text_;
};

// A trace, one step at a time.
class TraceReader {
 public:
  explicit TraceReader(const std::string& file) : name_(file) {
    require_regular_file(file, "a trace of firn run --trace-hashes");
    in_.open(file);
    if (!in_)
      throw InputError(file + ": cannot be read; expected a trace of firn run --trace-hashes");
    if (!std::getline(in_, line_) || line_ != kMagic)
      throw InputError(file + ":1: is not a trace; expected a file of firn run --trace-hashes");
    while (std::getline(in_, line_) && line_.starts_with('#')) {
      if (line_.starts_with(kCase)) case_hash = line_.substr(kCase.size());
      if (line_.starts_with(kGroups)) groups = split(line_.substr(kGroups.size()), ',');
    }
    next();
  }

  bool done = false;
  std::string case_hash;
  std::vector<std::string> groups;
  std::uint64_t step = 0;  // of the present one
  double time = 0;         // s
  std::vector<std::string> hashes;
  std::vector<std::string> numbers;  // lines

  // The last line of a run that was killed may be cut off: what is not whole is not there.
  void next() {
    done = true;
    if (!in_ || !line_.starts_with(kStep)) return;
    const std::vector<std::string> words = split(line_, ' ');
    if (words.size() != 3 + groups.size() || words.back().size() != 16) return;
    step = std::strtoull(words[1].c_str(), nullptr, 10);
    time = std::strtod(words[2].c_str(), nullptr);
    hashes.assign(words.begin() + 3, words.end());
    numbers.clear();
    while (std::getline(in_, line_) && !line_.starts_with(kStep)) numbers.push_back(line_);
    done = false;
  }

  static std::vector<std::string> split(const std::string& text, char by) {
    std::vector<std::string> words;
    std::size_t from = 0;
    for (std::size_t to = text.find(by); to != text.npos; to = text.find(by, from)) {
      words.push_back(text.substr(from, to - from));
      from = to + 1;
    }
    words.push_back(text.substr(from));
    return words;
  }

 private:
  std::string name_;
  std::ifstream in_;
  std::string line_;
};

// "particle 3" and its values by name; names have no blanks and follow the subject.
struct Entry {
  std::string subject;
  std::vector<std::pair<std::string, std::string>> values;
};

Entry entry_of(const std::string& line) {
  Entry e;
  for (const std::string& word : TraceReader::split(line, ' ')) {
    const std::size_t equals = word.find('=');
    if (equals == word.npos)
      e.subject += (e.subject.empty() ? "" : " ") + word;
    else
      e.values.emplace_back(word.substr(0, equals), word.substr(equals + 1));
  }
  return e;
}

// Adds a sentence for each value that differs.
void compare_numbers(const std::vector<std::string>& first, const std::vector<std::string>& second,
                     std::size_t listed, TraceDifference& out) {
  const auto report = [&](const std::string& sentence) {
    if (out.numbers.size() < listed) out.numbers.push_back(sentence);
    ++out.number_count;
  };
  std::map<std::string, Entry> others;
  for (const std::string& line : second) {
    Entry e = entry_of(line);
    others[e.subject] = std::move(e);
  }
  for (const std::string& line : first) {
    const Entry mine = entry_of(line);
    const auto found = others.find(mine.subject);
    if (found == others.end()) {
      report(mine.subject + ": only in the first");
      continue;
    }
    const Entry& other = found->second;
    for (std::size_t k = 0; k < mine.values.size() && k < other.values.size(); ++k) {
      if (mine.values[k] == other.values[k]) continue;
      report(fmt::format("{}: {} {:.17g} against {:.17g}", mine.subject, mine.values[k].first,
                         std::strtod(mine.values[k].second.c_str(), nullptr),
                         std::strtod(other.values[k].second.c_str(), nullptr)));
    }
    others.erase(found);
  }
  for (const auto& [subject, entry] : others) report(subject + ": only in the second");
}

}  // namespace

TraceWriter::TraceWriter(const Case& c, const TraceOptions& options)
    : options_(options), out_(options.file, OutputFile::When::at_once) {
  if (options_.every < 1) options_.every = 1;
  out_ << kMagic << "\n" << kCase << case_hash(c) << "\n";
}

void TraceWriter::add_step(const Solver& solver, bool last) {
  const std::uint64_t step = solver.steps();
  const bool numbers = step >= options_.numbers_from && step <= options_.numbers_to;
  if (begun_ && !last && !numbers && step % options_.every != 0) return;
  const std::vector<GroupHash> groups = solver.group_hashes();
  if (!begun_) {
    std::string names;
    for (const GroupHash& g : groups) names += (names.empty() ? "" : ",") + std::string(g.group);
    out_ << kGroups << names << "\n";
    begun_ = true;
  }
  std::string line = fmt::format("{}{} {:a}", kStep, step, solver.time());
  for (const GroupHash& g : groups) line += fmt::format(" {:016x}", g.hash);
  out_ << line << "\n";
  if (numbers) write_numbers(solver);
}

void TraceWriter::write_numbers(const Solver& solver) {
  const ParticleState& s = solver.particles();
  for (std::size_t i = 0; i < s.presence.size(); ++i) {
    if (s.presence[i] != Presence::present) continue;
    const Solver::Load load = solver.load(static_cast<int>(i));
    out_ << Line(fmt::format("particle {}", i))
                .add("position", s.position[i])
                .add("velocity", s.velocity[i])
                .add("angular_velocity", s.angular_velocity[i])
                .add("orientation", s.orientation[i])
                .add("contact_force", load.force)
                .add("contact_moment", load.moment)
                .add("peak_normal_force", s.peak_normal_force[i])
                .text();
  }
  const std::vector<BoundaryState>& walls = solver.boundaries();
  for (std::size_t b = 0; b < walls.size(); ++b) {
    out_ << Line(fmt::format("boundary {}", b))
                .add("position", walls[b].position)
                .add("orientation", walls[b].orientation)
                .add("impulse", walls[b].impulse)
                .add("angular_impulse", walls[b].angular_impulse)
                .text();
  }
  for (const Contact& c : solver.contacts()) {
    const std::string patch = fmt::format("pair {} {} patch {}", c.a, c.b, c.patch);
    out_ << Line(patch)
                .add("normal", c.normal)
                .add("place", c.position)
                .add("normal_force", c.normal_force)
                .add("friction", c.friction)
                .add("torsion", c.torsion)
                .add("sliding", c.sliding ? 1.0 : 0.0)
                .text();
    for (std::size_t k = 0; k < c.points.size(); ++k) {
      const ContactPointInfo& p = c.points[k];
      out_ << Line(fmt::format("{} point {}", patch, k))
                  .add("position", p.position)
                  .add("gap", p.gap)
                  .add("share", p.stiffness_fraction)
                  .add("force", p.force)
                  .text();
    }
  }
}

void TraceWriter::close() { out_.commit(); }

TraceDifference compare_traces(const std::string& first, const std::string& second,
                               std::size_t listed) {
  TraceReader a(first), b(second);
  if (a.groups != b.groups)
    throw InputError(fmt::format(
        "{}: holds other groups than {}; expected traces of versions of the program whose states "
        "are laid out alike",
        second, first));
  TraceDifference out;
  out.same_case = a.case_hash == b.case_hash;
  while (!a.done && !b.done) {
    if (a.step != b.step) {
      TraceReader& behind = a.step < b.step ? a : b;
      ++(a.step < b.step ? out.only_first : out.only_second);
      behind.next();
      continue;
    }
    ++out.steps_compared;
    if (a.hashes != b.hashes) {
      out.step = a.step;
      out.time = a.time;
      for (std::size_t k = 0; k < a.groups.size(); ++k)
        if (a.hashes[k] != b.hashes[k]) out.groups.push_back(a.groups[k]);
      out.has_numbers = !a.numbers.empty() && !b.numbers.empty();
      if (out.has_numbers) compare_numbers(a.numbers, b.numbers, listed, out);
      return out;
    }
    out.any_equal = true;
    out.last_equal = a.step;
    a.next();
    b.next();
  }
  for (; !a.done; a.next()) ++out.only_first;
  for (; !b.done; b.next()) ++out.only_second;
  if (out.steps_compared == 0)
    throw InputError(fmt::format(
        "{}: has no step in common with {}; expected traces of the same steps", second, first));
  out.equal = true;
  return out;
}

}  // namespace firn
