#include "experiments/case_reader/model/machine_parts.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "experiments/case_reader/model/shapes.h"
#include "experiments/machine/parts.h"

namespace firn {
namespace {

// Visits the keys of a part twice: first to collect their names, then to read them. The initial
// values of the members are the defaults.
class Keys {
 public:
  Keys() = default;
  explicit Keys(const TomlTable& table) : table_(&table) {}

  void length(std::string_view key, double& value, Sign sign = Sign::positive) {
    read(key, [&] {
      value = table_->quantity(key, dimension::length, sign, si_text(value, dimension::length));
    });
  }
  void angle(std::string_view key, double& value, Sign sign = Sign::non_negative) {
    read(key, [&] {
      value = table_->quantity(key, dimension::angle, sign, si_text(value, dimension::angle));
    });
  }
  void number(std::string_view key, double& value) {
    read(key, [&] { value = table_->number(key, value); });
  }
  void count(std::string_view key, int& value, int least) {
    read(key, [&] { value = table_->integer(key, least, value); });
  }
  // `value` is true for the word `yes`.
  void word(std::string_view key, bool& value, std::string_view yes, std::string_view no) {
    read(key, [&] { value = table_->choice(key, {yes, no}, value ? yes : no) == yes; });
  }
  void points(std::string_view key, std::vector<Vec3>& value) {
    read(key, [&] {
      if (!table_->has(key)) table_->fail(key, "missing; expected strings [\"x y z mm\", ...]");
      table_->at(key, [&] {
        for (const std::string& text : table_->strings(key)) {
          value.push_back(parse_vector(text, dimension::length));
        }
      });
    });
  }
  template <class Read>
  void read(std::string_view key, Read read_it) {
    names_.push_back(key);
    if (table_) read_it();
  }

  const TomlTable& table() const { return *table_; }
  const std::vector<std::string_view>& names() const { return names_; }

 private:
  const TomlTable* table_ = nullptr;
  std::vector<std::string_view> names_;
};

void keys(Keys& k, Mold& m) {
  for (const std::string_view key :
       {"chord", "thickness", "depth", "tip_height", "top_concavity_depth", "draft", "facets"}) {
    k.read(key, [] {});
  }
  k.read("variant", [&] { m.cube = read_crescent(k.table()).parameters; });
  k.count("cavities", m.cavities, 1);
  k.length("pitch", m.pitch);
  k.length("clearance", m.clearance, Sign::non_negative);
  k.length("freeboard", m.freeboard, Sign::non_negative);
  k.length("wall", m.wall);
  k.length("notch_width", m.notch_width, Sign::non_negative);
  k.length("notch_depth", m.notch_depth, Sign::non_negative);
}

void keys(Keys& k, Ejector& e) {
  k.count("blades", e.blades, 1);
  k.length("pitch", e.pitch);
  k.length("tip_radius", e.tip_radius);
  k.length("blade_width", e.blade_width);
  k.length("blade_thickness", e.blade_thickness);
  k.length("shaft_diameter", e.shaft_diameter);
  k.length("shaft_length", e.shaft_length);
}

void keys(Keys& k, Stripper& s) {
  k.count("blades", s.blades, 1);
  k.length("pitch", s.pitch);
  k.length("finger_width", s.finger_width);
  k.length("near", s.near, Sign::any);
  k.length("far", s.far, Sign::any);
  k.length("height", s.height, Sign::any);
  k.angle("slope", s.slope);
  k.length("thickness", s.thickness);
  k.length("apron", s.apron);
}

void keys(Keys& k, Wire& w) {
  k.length("diameter", w.diameter);
  k.points("points", w.points);
}

void keys(Keys& k, Bucket& b) {
  k.length("length", b.length);
  k.length("width", b.width);
  k.length("back_height", b.back_height);
  k.length("front_height", b.front_height);
  k.length("wall", b.wall);
  k.angle("draft", b.draft);
  k.length("trough_radius", b.trough_radius, Sign::non_negative);
  k.angle("shoulder", b.shoulder, Sign::positive);
  k.read("outlet", [&] {
    const std::string outlet = k.table().choice("outlet", {"none", "end", "floor"}, "none");
    b.outlet = outlet == "end"     ? Bucket::Outlet::end
               : outlet == "floor" ? Bucket::Outlet::floor
                                   : Bucket::Outlet::none;
  });
  k.length("outlet_width", b.outlet_width);
  k.length("outlet_height", b.outlet_height);
  k.length("outlet_length", b.outlet_length);
}

void keys(Keys& k, Auger& a) {
  k.length("outer_diameter", a.outer_diameter);
  k.length("shaft_diameter", a.shaft_diameter);
  k.length("pitch", a.pitch);
  k.number("turns", a.turns);
  k.length("blade_thickness", a.blade_thickness);
  k.length("overhang", a.overhang);
  k.word("hand", a.left_handed, "left", "right");
}

void keys(Keys& k, WireAuger& a) {
  k.length("outer_diameter", a.outer_diameter);
  k.length("wire_diameter", a.wire_diameter);
  k.length("pitch", a.pitch);
  k.number("turns", a.turns);
  k.word("hand", a.left_handed, "left", "right");
}

void keys(Keys& k, Trough& t) {
  k.length("radius", t.radius);
  k.length("length", t.length);
  k.length("wall", t.wall);
  k.angle("angle", t.angle, Sign::positive);
}

void keys(Keys& k, Chute& c) {
  k.word("section", c.round, "round", "rectangular");
  k.length("width", c.width);
  k.length("height", c.height);
  k.length("diameter", c.diameter);
  k.length("wall", c.wall);
  k.angle("inclination", c.inclination, Sign::any);
  k.length("length", c.length);
  k.angle("bend", c.bend, Sign::any);
  k.length("bend_length", c.bend_length);
}

void keys(Keys& k, Container& c) {
  k.word("section", c.round, "round", "rectangular");
  k.length("diameter", c.diameter);
  k.length("length", c.length);
  k.length("width", c.width);
  k.length("height", c.height);
  k.length("wall", c.wall);
  k.length("floor", c.floor);
}

void keys(Keys& k, Drum& d) {
  k.length("diameter", d.diameter);
  k.length("length", d.length);
  k.length("wall", d.wall);
  k.count("lifters", d.lifters, 0);
  k.length("lifter_height", d.lifter_height);
  k.length("lifter_thickness", d.lifter_thickness);
}

void keys(Keys& k, Platen& p) {
  k.word("section", p.round, "round", "rectangular");
  k.length("diameter", p.diameter);
  k.length("length", p.length);
  k.length("width", p.width);
  k.length("thickness", p.thickness);
}

void keys(Keys& k, TrapDoorBox& b) {
  k.length("length", b.length);
  k.length("width", b.width);
  k.length("height", b.height);
  k.length("wall", b.wall);
  k.length("floor", b.floor);
  k.length("door_length", b.door_length);
}

template <class Part, Solid (*make)(const Part&)>
Solid read(const TomlTable& table, std::span<const std::string_view> common) {
  Part part;
  Keys names;
  keys(names, part);
  std::vector<std::string_view> allowed(common.begin(), common.end());
  allowed.insert(allowed.end(), names.names().begin(), names.names().end());
  table.allow(allowed);
  Keys reader(table);
  keys(reader, part);
  // A batch reads its case again for every run, mostly with the same part: the last one is cached.
  thread_local std::optional<std::pair<Part, Solid>> last;
  try {
    if (!last || last->first != part) last.emplace(part, make(part));
    return last->second;
  } catch (const DimensionError& error) {
    table.fail(error.key, error.message);
  }
}

using Reader = Solid (*)(const TomlTable&, std::span<const std::string_view>);
constexpr std::array<std::string_view, 13> kKinds = {
    "mold",   "ejector", "stripper",  "wire", "bucket", "auger",        "wire_auger",
    "trough", "chute",   "container", "drum", "platen", "trap_door_box"};
constexpr std::array<Reader, 13> kReaders = {read<Mold, make_mold>,
                                             read<Ejector, make_ejector>,
                                             read<Stripper, make_stripper>,
                                             read<Wire, make_wire>,
                                             read<Bucket, make_bucket>,
                                             read<Auger, make_auger>,
                                             read<WireAuger, make_wire_auger>,
                                             read<Trough, make_trough>,
                                             read<Chute, make_chute>,
                                             read<Container, make_container>,
                                             read<Drum, make_drum>,
                                             read<Platen, make_platen>,
                                             read<TrapDoorBox, make_trap_door_box>};

}  // namespace

std::span<const std::string_view> machine_kinds() { return kKinds; }

Solid read_machine_part(const TomlTable& table, std::string_view kind,
                        std::span<const std::string_view> common) {
  const auto found = std::ranges::find(kKinds, kind);
  return kReaders[static_cast<std::size_t>(found - kKinds.begin())](table, common);
}

}  // namespace firn
