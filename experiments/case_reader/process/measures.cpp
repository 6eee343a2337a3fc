#include "experiments/case_reader/process/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "experiments/analysis/channel_filter.h"
#include "experiments/case/samples.h"
#include "experiments/case_reader/model/boundaries.h"
#include "experiments/case_reader/model/motion_frames.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

void read_slip(const TomlTable& t, const Model& model, Measure& m) {
  t.allow({"kind", "name", "tag", "boundary", "slip", "tip_window", "tip_rotation"});
  m.boundary = t.string("boundary");
  boundary_index(t, "boundary", m.boundary, model.boundaries);
  m.slip = t.quantity("slip", dimension::length, Sign::positive, "2 mm");
  m.run = t.quantity("tip_window", dimension::length, Sign::positive, "20 mm");
  m.tip_angle = t.quantity("tip_rotation", dimension::angle, Sign::positive, "20 deg");
  if (m.run < m.slip) {
    t.fail("tip_window", fmt::format("is {:.4g} m, less than the slip of {:.4g} m; expected more",
                                     m.run, m.slip));
  }
}

void read_slide(const TomlTable& t, const Model& model, Measure& m) {
  t.allow({"kind", "name", "tag", "boundary", "from", "to"});
  m.boundary = t.string("boundary");
  boundary_index(t, "boundary", m.boundary, model.boundaries);
  m.from = t.quantity("from", dimension::length, Sign::non_negative, "0 m");
  m.to = t.quantity("to", dimension::length, Sign::positive);
  if (m.to <= m.from) {
    t.fail("to", fmt::format("is {:.4g} m, not beyond the mark at {:.4g} m; expected more", m.to,
                             m.from));
  }
}

void read_heap(const TomlTable& t, Measure& m) {
  t.allow({"kind", "name", "tag", "region_min", "region_max", "peak", "peak_margin", "end_margin"});
  m.region_min = t.vector("region_min", dimension::length);
  m.region_max = t.vector("region_max", dimension::length);
  if ((m.region_max - m.region_min).minCoeff() <= 0) {
    t.fail("region_max", "is not beyond region_min along every axis; expected a box");
  }
  m.peak = t.quantity("peak", dimension::length, Sign::any);
  m.peak_margin = t.quantity("peak_margin", dimension::length, Sign::non_negative, "25 mm");
  m.end_margin = t.quantity("end_margin", dimension::length, Sign::non_negative, "25 mm");
  const double shorter = std::min(m.peak - m.region_min.x(), m.region_max.x() - m.peak);
  if (m.peak_margin + m.end_margin >= shorter) {
    t.fail("peak", fmt::format("leaves a side of {:.4g} m and margins of {:.4g} m and {:.4g} m; "
                               "expected a line to fit on both sides",
                               shorter, m.peak_margin, m.end_margin));
  }
}

// Refuses before the run what the responses would refuse after it.
void check_heap_window(const TomlTable& t, const Model& model, const Measure& m) {
  // The smallest particle that counts; the responses take the mean of those in the bin.
  double particle_size = std::numeric_limits<double>::infinity();
  for (const Particle& p : model.particles)
    if (!m.tag || p.tag == *m.tag)
      particle_size = std::min(particle_size, middle_edge(model.shapes[p.shape]));
  const double shorter = std::min(m.peak - m.region_min.x(), m.region_max.x() - m.peak);
  const double window = shorter - m.peak_margin - m.end_margin;
  if (std::isfinite(particle_size) && window < 2 * particle_size) {
    t.fail("peak", fmt::format("and the margins leave {:.4g} m of a side of {:.4g} m to fit a line "
                               "to, less than two particle sizes ({:.4g} m); expected smaller "
                               "margins or a longer bin",
                               window, shorter, 2 * particle_size));
  }
}

void read_drum(const TomlTable& t, const Model& model, Measure& m) {
  t.allow({"kind", "name", "tag", "boundary", "axis", "begin"});
  m.boundary = t.string("boundary");
  const int drum = boundary_index(t, "boundary", m.boundary, model.boundaries);
  if (model.boundaries[static_cast<std::size_t>(drum)].mesh.triangles.empty())
    t.fail("boundary", fmt::format("\"{}\" is a plane; expected a drum", m.boundary));
  m.axis = t.choice("axis", {"x", "y"}, "x") == "x" ? 0 : 1;
  m.begin = t.quantity("begin", dimension::time, Sign::non_negative);
}

// A channel frequency class needs a minimum number of records per period. `quantities`: that are
// filtered.
void require_records(const TomlTable& t, const Case& c, const Measure& m,
                     std::initializer_list<std::string_view> quantities) {
  const bool sampled = has_samples(c, m, quantities);
  const double interval = sampled ? c.samples.interval : c.frame_interval;
  if (interval * kSamplesPerClass * m.cfc <= 1 + 1e-9) return;
  t.fail("cfc",
         fmt::format("of {:g} Hz needs a sample every {:.3g} ms, and {} are {:.3g} ms apart; "
                     "expected {}",
                     m.cfc, 1e3 / (kSamplesPerClass * m.cfc), sampled ? "samples" : "frames",
                     1e3 * interval,
                     sampled ? "a shorter output.samples.interval"
                             : "a shorter output.frame_interval, or [output.samples] of the part"));
}

void read_accelerometer(const TomlTable& t, const Case& c, Measure& m) {
  const Model& model = c.model;
  t.allow({"kind", "name", "motion_frame", "axis", "cfc"});
  m.frame = frame_index(t, "motion_frame", model.frames);
  m.axis = t.integer("axis", 0, 0);
  const std::optional<FreeBody>& free = model.frames[static_cast<std::size_t>(m.frame)].free;
  const bool moves =
      free && m.axis < static_cast<int>(free->joints.size()) &&
      free->joints[static_cast<std::size_t>(m.axis)].kind == Joint::Kind::translation;
  if (!moves) t.fail("axis", "is no translation of a free motion frame; expected one");
  m.cfc = t.quantity("cfc", dimension::frequency, Sign::positive, "1000 Hz");
  require_records(t, c, m, {"acceleration", "force"});
}

// Where responses cannot do without the name of their measure.
void require_name(const TomlTable& t) {
  if (t.string("name", "").empty())
    t.fail("name", "is missing; expected a name, which the responses bear");
}

// Of a measure of a part of a machine.
void require_one_body(const TomlTable& t) {
  if (t.has("boundary") + t.has("motion_frame") + t.has("boundary_contact") + t.has("coupling") !=
      1)
    t.fail("boundary",
           "motion_frame, boundary_contact and coupling exclude each other; expected one of them");
  require_name(t);
}

int contact_index(const TomlTable& t, const Model& model) {
  return index_of(t, "boundary_contact", t.string("boundary_contact"), model.boundary_contacts,
                  "boundary contact");
}

int coupling_index(const TomlTable& t, const Model& model) {
  return index_of(t, "coupling", t.string("coupling"), model.couplings, "coupling");
}

// Results have the energy that friction dissipates only where there is friction.
void require_friction(const TomlTable& t, const Measure& m, bool has_friction) {
  if (m.y == "dissipated_friction" && !has_friction)
    t.fail("y", "is \"dissipated_friction\" of a part without friction; expected another one");
}

// Of the x of a curve.
const Dimension& dimension_of_x(const Model& model, const Measure& m) {
  if (m.x == "time") return dimension::time;
  if (m.x == "displacement") return dimension::length;
  const MotionFrame& frame = model.frames[static_cast<std::size_t>(m.frame)];
  const Joint& joint = frame.free->joints[static_cast<std::size_t>(m.axis)];
  return joint.kind == Joint::Kind::rotation ? dimension::angle : dimension::length;
}

void read_curve(const TomlTable& t, const Case& c, Measure& m) {
  const Model& model = c.model;
  t.allow({"kind", "name", "boundary", "motion_frame", "boundary_contact", "coupling", "axis", "x",
           "x_period", "y", "points", "cfc"});
  require_one_body(t);
  if (t.has("boundary")) {
    m.boundary = t.string("boundary");
    boundary_index(t, "boundary", m.boundary, model.boundaries);
    if (t.has("axis")) t.fail("axis", "is given without motion_frame; expected no axis");
    m.x = t.choice("x", {"time", "displacement"}, "time");
    m.y = t.choice("y", {"force", "torque", "peak_normal_force"});
  } else if (t.has("boundary_contact")) {
    m.contact = contact_index(t, model);
    if (t.has("axis")) t.fail("axis", "is given without motion_frame; expected no axis");
    m.x = t.choice("x", {"time"}, "time");
    m.y = t.choice("y", {"force", "peak_normal_force"});
  } else if (t.has("coupling")) {
    m.coupling = coupling_index(t, model);
    if (t.has("axis")) t.fail("axis", "is given without motion_frame; expected no axis");
    m.x = t.choice("x", {"time"}, "time");
    m.y = t.choice("y", {"force", "torque", "dissipated_friction"});
    require_friction(t, m, model.couplings[static_cast<std::size_t>(m.coupling)].has_friction());
  } else {
    m.frame = frame_index(t, "motion_frame", model.frames);
    m.axis = t.integer("axis", 0, 0);
    const std::optional<FreeBody>& free = model.frames[static_cast<std::size_t>(m.frame)].free;
    if (!free || m.axis >= static_cast<int>(free->joints.size()))
      t.fail("axis",
             fmt::format("is {}, and motion frame \"{}\" has {} joints; expected the index of "
                         "a joint of a free motion frame",
                         m.axis, model.frames[static_cast<std::size_t>(m.frame)].name,
                         free ? free->joints.size() : 0));
    m.x = t.choice("x", {"time", "coordinate"}, "time");
    m.y = t.choice("y", {"coordinate", "rate", "acceleration", "motor_load", "force",
                         "reaction_force", "dissipated_friction"});
    require_friction(t, m, free->has_joint_friction());
  }
  m.x_period =
      t.optional_quantity("x_period", dimension_of_x(model, m), Sign::positive).value_or(0);
  m.points = t.integer("points", 2, 500);
  if (m.points > 20000) t.fail("points", "are too many for a response; expected 20000 at most");
  m.cfc = t.optional_quantity("cfc", dimension::frequency, Sign::positive).value_or(0);
  require_records(t, c, m, {m.x, m.y});
}

void read_measured_stage(const TomlTable& t, const Case& c, Measure& m) {
  m.stage = t.string("stage", "");
  if (!m.stage.empty() && std::ranges::count(c.stages, m.stage, &Stage::name) == 0)
    t.fail("stage", fmt::format("\"{}\" is not a stage; expected one of [[stages]]", m.stage));
}

void read_load(const TomlTable& t, const Case& c, Measure& m) {
  t.allow({"kind", "name", "boundary", "motion_frame", "boundary_contact", "coupling", "direction",
           "stage"});
  require_one_body(t);
  if (t.has("boundary")) {
    m.boundary = t.string("boundary");
    boundary_index(t, "boundary", m.boundary, c.model.boundaries);
  } else if (t.has("boundary_contact")) {
    m.contact = contact_index(t, c.model);
  } else if (t.has("coupling")) {
    m.coupling = coupling_index(t, c.model);
  } else {
    m.frame = frame_index(t, "motion_frame", c.model.frames);
  }
  if (t.has("direction")) m.direction = t.direction("direction");
  read_measured_stage(t, c, m);
}

void read_above(const TomlTable& t, const Case& c, Measure& m) {
  t.allow({"kind", "name", "boundary", "stage"});
  require_name(t);
  m.boundary = t.string("boundary");
  boundary_index(t, "boundary", m.boundary, c.model.boundaries);
  read_measured_stage(t, c, m);
}

}  // namespace

std::vector<Measure> read_measures(const TomlTable& root, const Case& c) {
  const Model& model = c.model;
  std::vector<Measure> measures;
  for (const TomlTable& t : root.tables("measure")) {
    const std::string kind = t.choice("kind", {"sliding_onset", "slide", "rebound", "heap",
                                               "accelerometer", "drum", "curve", "load", "above"});
    Measure m;
    if (kind == "sliding_onset") {
      m.kind = Measure::Kind::slip;
      read_slip(t, model, m);
    } else if (kind == "slide") {
      m.kind = Measure::Kind::slide;
      read_slide(t, model, m);
    } else if (kind == "rebound") {
      m.kind = Measure::Kind::rebound;
      t.allow({"kind", "name", "tag"});
    } else if (kind == "accelerometer") {
      m.kind = Measure::Kind::accelerometer;
      read_accelerometer(t, c, m);
    } else if (kind == "curve") {
      m.kind = Measure::Kind::curve;
      read_curve(t, c, m);
    } else if (kind == "load") {
      m.kind = Measure::Kind::load;
      read_load(t, c, m);
    } else if (kind == "above") {
      m.kind = Measure::Kind::above;
      read_above(t, c, m);
    } else if (kind == "drum") {
      m.kind = Measure::Kind::drum;
      read_drum(t, model, m);
    } else {
      m.kind = Measure::Kind::heap;
      read_heap(t, m);
    }
    if (model.gravity.norm() == 0 &&
        (kind == "sliding_onset" || kind == "rebound" || kind == "above")) {
      t.fail("kind", fmt::format("is \"{}\" without gravity; expected a case with one", kind));
    }
    m.name = t.string("name", "");
    // The name becomes part of a path in results files.
    if (!m.name.empty()) valid_name(t);
    for (const Measure& other : measures) {
      if (other.kind == m.kind && other.name == m.name) {
        t.fail("name", fmt::format("\"{}\" is taken by another measure of this kind; expected "
                                   "another name",
                                   m.name));
      }
    }
    if (t.has("tag")) {
      m.tag = t.integer("tag", 0);
      if (std::ranges::count(model.particles, *m.tag, &Particle::tag) == 0) {
        t.fail("tag", fmt::format("no particle carries {}; expected the tag of one", *m.tag));
      }
    }
    if (m.kind == Measure::Kind::heap) check_heap_window(t, model, m);
    measures.push_back(m);
  }
  return measures;
}

}  // namespace firn
