#include "experiments/case_reader/initial_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/case_reader/model/shapes.h"
#include "experiments/results/bond_results.h"
#include "experiments/results/results_file.h"

namespace firn {
namespace {

constexpr double kSame = 1e-9;  // relative: numbers written in different units agree to this

bool close(double a, double b) {
  return std::abs(a - b) <= kSame * std::max(std::abs(a), std::abs(b));
}
bool close(const Vec3& a, const Vec3& b, double size) { return (a - b).norm() <= kSame * size; }

std::string vector_text(const Vec3& v, const Dimension& d) {
  return fmt::format("{} {} {}", v.x(), v.y(), si_text(v.z(), d));
}
toml::array orientation_list(const Quat& q) { return toml::array{q.w(), q.x(), q.y(), q.z()}; }

// One frame of an earlier run and the case of that run.
struct Earlier {
  std::string file;
  Recording recording;
  Case c;
  std::size_t row = 0;
  double time = 0;  // s

  std::vector<double> frame_values(const std::string& frame, const char* what) const {
    const std::string path = "/motion_frames/" + frame + "/" + what;
    if (!recording.contains(path))
      throw InputError(fmt::format("{}: has no {}; run that case again", file, path));
    const std::vector<double> all = recording.series(path);
    const std::size_t width = all.size() / recording.frame_count();
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(row * width);
    return {first, first + static_cast<std::ptrdiff_t>(width)};
  }
};

// The last frame of a finished run, or the one nearest to the time asked for.
std::size_t choose_frame(const TomlTable& t, const Earlier& earlier) {
  const std::vector<double> times = earlier.recording.frame_times();
  if (times.empty())
    t.fail("file",
           fmt::format("\"{}\" has no frames; expected a run with at least one", earlier.file));
  if (!t.has("time")) {
    const std::string status = earlier.recording.status();
    if (status != "finished")
      t.fail("file", fmt::format("\"{}\" holds a run that is not finished ({}); expected a "
                                 "finished one, or a time",
                                 earlier.file, status));
    return times.size() - 1;
  }
  const double wanted = t.quantity("time", dimension::time, Sign::non_negative);
  const auto nearest =
      std::ranges::min_element(times, {}, [&](double time) { return std::abs(time - wanted); });
  if (std::abs(*nearest - wanted) > 0.5 * earlier.c.frame_interval + earlier.c.model.timestep)
    t.fail("time", fmt::format("is {} s, where \"{}\" has no frame; expected a time from {} s to "
                               "{} s",
                               wanted, earlier.file, times.front(), times.back()));
  return static_cast<std::size_t>(nearest - times.begin());
}

// What of two shapes differs, and how; empty: nothing. Their stiffness may.
std::string difference(const Shape& here, const Shape& there) {
  const auto numbers = [](const char* what, double a, double b, const char* unit) {
    return fmt::format("{} is {:.9g} {} here and {:.9g} {} there", what, a, unit, b, unit);
  };
  if (!close(here.mass, there.mass)) return numbers("mass", here.mass, there.mass, "kg");
  if (!close(here.volume, there.volume)) return numbers("volume", here.volume, there.volume, "m^3");
  if (!close(here.rounding, there.rounding))
    return numbers("rounding", here.rounding, there.rounding, "m");
  for (int k = 0; k < 3; ++k) {
    if (!close(here.box[k], there.box[k]))
      return numbers("size along an axis", here.box[k], there.box[k], "m");
  }
  const double size = here.box.maxCoeff();
  const auto same_point = [&](const Vec3& a, const Vec3& b) { return close(a, b, size); };
  if (!std::ranges::equal(here.mesh.vertices, there.mesh.vertices, same_point) ||
      here.mesh.triangles != there.mesh.triangles)
    return "their meshes differ";
  const auto same_part = [&](const ConvexPart& a, const ConvexPart& b) {
    return a.vertex_count == b.vertex_count && close(a.center, b.center, size);
  };
  if (!std::ranges::equal(here.parts, there.parts, same_part))
    return fmt::format("it has {} convex parts here and {} there, or others", here.parts.size(),
                       there.parts.size());
  return {};
}

void check_shapes(const TomlTable& t, const Model& model, const Earlier& earlier,
                  const std::vector<std::size_t>& taken) {
  const std::vector<int> shape = earlier.recording.shape();
  for (std::size_t s = 0; s < earlier.c.model.shapes.size(); ++s) {
    const Shape& there = earlier.c.model.shapes[s];
    const auto is_it = [&](std::size_t i) { return shape[i] == static_cast<int>(s); };
    if (std::ranges::none_of(taken, is_it)) continue;
    const auto here = std::ranges::find(model.shapes, there.name, &Shape::name);
    if (here == model.shapes.end())
      t.fail("file", fmt::format("\"{}\" has particles of shape \"{}\", and the case has no such "
                                 "shape; expected [shapes.{}]",
                                 earlier.file, there.name, there.name));
    const std::string differs = difference(*here, there);
    if (!differs.empty())
      t.fail("file", fmt::format("shape \"{}\" is another one in \"{}\": {}; expected the same",
                                 there.name, earlier.file, differs));
  }
}

// Ids of those present in the frame, and asked for.
std::vector<std::size_t> chosen_particles(const TomlTable& t, const Earlier& earlier,
                                          const Frame& frame) {
  const std::vector<int> tag = earlier.recording.tag(), batch = earlier.recording.batch();
  const std::vector<int> tags = t.integers("tags"), batches = t.integers("batches");
  const auto asked = [&](const char* key, const std::vector<int>& list, int value) {
    return !t.has(key) || std::ranges::count(list, value) > 0;
  };
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < frame.position.size(); ++i) {
    if (std::isnan(frame.position[i][0])) continue;
    if (asked("tags", tags, tag[i]) && asked("batches", batches, batch[i])) taken.push_back(i);
  }
  if (taken.empty())
    t.fail("file", fmt::format("\"{}\" has none of the particles asked for at {} s; expected at "
                               "least one",
                               earlier.file, earlier.time));
  return taken;
}

void fill_in_particles(const TomlTable& t, const Earlier& earlier, const Frame& frame,
                       const std::vector<std::size_t>& taken) {
  const Recording& r = earlier.recording;
  const std::vector<int> shape = r.shape(), tag = r.tag(), batch = r.batch();
  const std::vector<double> inserted = r.insert_time();
  toml::array particles;
  for (const std::size_t i : taken) {
    const auto at = [](const std::array<double, 3>& v) { return Vec3(v.data()); };
    const auto& q = frame.orientation[i];
    particles.push_back(
        toml::table{{"shape", earlier.c.model.shapes[static_cast<std::size_t>(shape[i])].name},
                    {"tag", tag[i]},
                    {"batch", batch[i]},
                    {"insert_time", si_text(inserted[i] - earlier.time, dimension::time)},
                    {"position", vector_text(at(frame.position[i]), dimension::length)},
                    {"orientation", orientation_list(Quat(q[0], q[1], q[2], q[3]))},
                    {"velocity", vector_text(at(frame.velocity[i]), dimension::velocity)},
                    {"angular_velocity",
                     vector_text(at(frame.angular_velocity[i]), dimension::angular_velocity)}});
  }
  t.set("particles", std::move(particles));
}

// Those between particles that are taken.
void fill_in_bonds(const TomlTable& t, const Earlier& earlier, const Frame& frame,
                   const std::vector<std::size_t>& taken) {
  const Model& there = earlier.c.model;
  std::vector<int> number(there.particles.size(), -1);  // in this case
  for (std::size_t k = 0; k < taken.size(); ++k) number[taken[k]] = static_cast<int>(k);
  toml::array bonds;
  for (const BondBox& one :
       intact_bonds_at(earlier.c, bond_outcomes(earlier.recording), earlier.time, frame)) {
    const Bond& bond = there.bonds[index(one.bond)];
    if (!is_particle(there, bond.b)) continue;
    const int a = number[index(bond.a)], b = number[index(bond.b)];
    if (a < 0 || b < 0) continue;
    const BeamLaw& law = there.beams[index(bond.law)];
    bonds.push_back(toml::table{{"name", law.name},
                                {"a", a},
                                {"b", b},
                                {"length", si_text(law.length, dimension::length)},
                                {"end_a", vector_text(bond.end_a, dimension::length)},
                                {"end_b", vector_text(bond.end_b, dimension::length)},
                                {"axes_a", orientation_list(bond.axes_a)},
                                {"axes_b", orientation_list(bond.axes_b)},
                                {"strength", bond.strength}});
  }
  if (!bonds.empty() || t.has("bonds")) t.set("bonds", std::move(bonds));
}

// Coordinates mean the same: the same origin, and for a free frame the same axes and carrier.
void check_frame(const TomlTable& t, const Model& here, const Model& there, const MotionFrame& a,
                 const MotionFrame& b, const std::string& file) {
  const auto carrier = [](const Model& m, const MotionFrame& f) {
    return f.parent < 0 ? std::string("the world")
                        : m.frames[static_cast<std::size_t>(f.parent)].name;
  };
  const auto refuse = [&](const char* what) {
    t.fail("file", fmt::format("motion frame \"{}\" is another one in \"{}\": its {} differs; "
                               "expected the same, or another name",
                               a.name, file, what));
  };
  if (!close(a.origin, b.origin, std::max(a.origin.norm(), 1.0))) refuse("position");
  if (carrier(here, a) != carrier(there, b)) refuse("parent");
  if (!a.free) return;
  if (!b.free) refuse("freedom to move");
  const auto same_axis = [](const Joint& x, const Joint& y) {
    return x.kind == y.kind && close(x.direction, y.direction, 1);
  };
  if (a.free->free_rotation != b.free->free_rotation ||
      !std::ranges::equal(a.free->joints, b.free->joints, same_axis))
    refuse("set of axes");
}

// "0.1 rad", ...
toml::array axis_texts(const std::vector<Joint>& axes, const std::vector<double>& values,
                       const Dimension& along, const Dimension& about) {
  toml::array texts;
  for (std::size_t k = 0; k < axes.size(); ++k)
    texts.push_back(si_text(values.at(k), axes[k].kind == Joint::Kind::rotation ? about : along));
  return texts;
}

void fill_in_frames(const TomlTable& t, const Model& model, const Earlier& earlier) {
  toml::array frames;
  for (const MotionFrame& frame : model.frames) {
    const Model& there = earlier.c.model;
    const auto same = std::ranges::find(there.frames, frame.name, &MotionFrame::name);
    if (same == there.frames.end()) continue;
    check_frame(t, model, there, frame, *same, earlier.file);
    const auto values = [&](const char* what) {
      return t.at("file", [&] { return earlier.frame_values(frame.name, what); });
    };
    const std::vector<double> p = values("position"), q = values("orientation");
    toml::table one{{"name", frame.name},
                    {"position", vector_text(Vec3(p.data()), dimension::length)},
                    {"orientation", orientation_list(Quat(q.at(0), q.at(1), q.at(2), q.at(3)))}};
    if (frame.free && !frame.free->joints.empty()) {
      const std::vector<Joint>& axes = frame.free->joints;
      one.insert("coordinates",
                 axis_texts(axes, values("coordinate"), dimension::length, dimension::angle));
      one.insert("rates", axis_texts(axes, values("rate"), dimension::velocity,
                                     dimension::angular_velocity));
    }
    if (frame.free && frame.free->free_rotation) {
      const std::vector<double> w = values("angular_velocity");
      one.insert("relative_angular_velocity",
                 vector_text(Vec3(w.data()), dimension::angular_velocity));
    }
    frames.push_back(std::move(one));
  }
  t.set("motion_frames", std::move(frames));
}

void take_over(const TomlTable& t, const std::string& directory, const Model& model) {
  const std::string file =
      std::filesystem::absolute(std::filesystem::path(directory) / t.string("file"))
          .lexically_normal()
          .string();
  Earlier earlier = t.at("file", [&] {
    Recording recording(file);
    Case c = read_case(recording);
    return Earlier{file, std::move(recording), std::move(c)};
  });
  earlier.row = choose_frame(t, earlier);
  earlier.time = earlier.recording.frame_times()[earlier.row];
  const Frame frame = earlier.recording.frame(earlier.row);
  const std::vector<std::size_t> taken = chosen_particles(t, earlier, frame);
  check_shapes(t, model, earlier, taken);
  fill_in_particles(t, earlier, frame, taken);
  fill_in_bonds(t, earlier, frame, taken);
  fill_in_frames(t, model, earlier);
  t.set("file", file);
  t.set("time", si_text(earlier.time, dimension::time));
}

void read_placed(const TomlTable& t, Case& c) {
  for (const TomlTable& one : t.tables("particles")) {
    one.allow({"shape", "tag", "batch", "insert_time", "position", "orientation", "velocity",
               "angular_velocity"});
    Case::InitialParticle p;
    p.particle = static_cast<int>(c.model.particles.size());
    p.position = one.vector("position", dimension::length);
    p.orientation = one.orientation("orientation");
    p.velocity = one.vector("velocity", dimension::velocity);
    p.angular_velocity = one.vector("angular_velocity", dimension::angular_velocity);
    p.insert_time = one.quantity("insert_time", dimension::time, Sign::any);
    p.batch = one.integer("batch", -1);
    c.model.particles.push_back({shape_index(one, "shape", c.model.shapes), one.integer("tag", 0)});
    c.placed.push_back(p);
    c.particle_places.push_back(t.place());
  }
}

void read_initial_bonds(const TomlTable& t, Case& c) {
  const int most = static_cast<int>(c.placed.size()) - 1;
  for (const TomlTable& one : t.tables("bonds")) {
    one.allow({"name", "a", "b", "length", "end_a", "end_b", "axes_a", "axes_b", "strength"});
    Case::InitialBond bond;
    bond.name = one.string("name");
    bond.length = one.quantity("length", dimension::length, Sign::positive);
    bond.bond.a = one.integer("a", 0, 0);
    bond.bond.b = one.integer("b", 0, 0);
    for (const auto& [key, body] : {std::pair{"a", bond.bond.a}, {"b", bond.bond.b}})
      if (body > most)
        one.fail(key, fmt::format("is {}; expected the number of one of the particles, at most {}",
                                  body, most));
    bond.bond.end_a = one.vector("end_a", dimension::length);
    bond.bond.end_b = one.vector("end_b", dimension::length);
    bond.bond.axes_a = one.orientation("axes_a");
    bond.bond.axes_b = one.orientation("axes_b");
    bond.bond.strength = one.number("strength", 1);
    c.initial_bonds.push_back(bond);
  }
}

// One value an axis.
std::vector<double> axis_values(const TomlTable& t, std::string_view key,
                                const std::vector<Joint>& axes, const Dimension& along,
                                const Dimension& about) {
  const std::vector<std::string> texts = t.strings(key);
  if (texts.size() != axes.size())
    t.fail(key, fmt::format("has {} values; expected one for each of {} axes", texts.size(),
                            axes.size()));
  std::vector<double> values;
  for (std::size_t k = 0; k < axes.size(); ++k)
    values.push_back(t.at(key, [&] {
      return parse_quantity(texts[k], axes[k].kind == Joint::Kind::rotation ? about : along);
    }));
  return values;
}

void read_frame_starts(const TomlTable& t, Case& c) {
  for (const TomlTable& one : t.tables("motion_frames")) {
    one.allow(
        {"name", "position", "orientation", "coordinates", "rates", "relative_angular_velocity"});
    FrameStart start;
    start.frame = frame_index(one, "name", c.model.frames);
    start.position = one.vector("position", dimension::length);
    start.orientation = one.orientation("orientation");
    const std::optional<FreeBody>& free =
        c.model.frames[static_cast<std::size_t>(start.frame)].free;
    if (free) {
      start.coordinates =
          axis_values(one, "coordinates", free->joints, dimension::length, dimension::angle);
      start.rates =
          axis_values(one, "rates", free->joints, dimension::velocity, dimension::angular_velocity);
      if (free->free_rotation)
        start.relative_angular_velocity =
            one.vector("relative_angular_velocity", dimension::angular_velocity);
    }
    c.frame_starts.push_back(start);
  }
  std::ranges::sort(c.frame_starts, {}, &FrameStart::frame);
}

}  // namespace

void read_initial_state(const TomlTable& root, const std::string& directory, Case& c) {
  if (!root.has("initial_state")) return;
  const TomlTable t = root.required_table("initial_state");
  t.allow({"file", "time", "tags", "batches", "particles", "bonds", "motion_frames"});
  // A resolved case holds the values from the results file. They are read again only if an override
  // changes the selection.
  const auto is_key_overridden = [&](const char* key) {
    return t.document().overridden(std::string("initial_state.") + key);
  };
  if (!t.has("particles") || is_key_overridden("file") || is_key_overridden("time") ||
      is_key_overridden("tags") || is_key_overridden("batches"))
    take_over(t, directory, c.model);
  read_placed(t, c);
  read_initial_bonds(t, c);
  read_frame_starts(t, c);
  c.start = fmt::format("{} particles and {} motion frames of {} at {}", c.placed.size(),
                        c.frame_starts.size(), t.string("file"), t.string("time"));
}

}  // namespace firn
