#include <fmt/format.h>

#include <functional>

#include "experiments/inspection/contact_inspection.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

std::string text_of(const Vec3& v) { return fmt::format("{} {} {}\n", v.x(), v.y(), v.z()); }

}  // namespace

void write_contacts_vtk(const std::vector<ContactView>& contacts, const std::string& file) {
  std::string points, vertices, force, friction;
  std::size_t count = 0;
  for (const ContactView& view : contacts) {
    for (const ContactSpot& spot : view.contact.spots) {
      points += text_of(spot.position);
      vertices += fmt::format("1 {}\n", count++);
      force += text_of(-spot.force * view.contact.normal);
      friction += text_of(view.contact.friction);
    }
  }
  OutputFile out(file);
  out << "# vtk DataFile Version 3.0\ncontacts\nASCII\nDATASET POLYDATA\n"
      << fmt::format("POINTS {} double\n", count) << points
      << fmt::format("VERTICES {} {}\n", count, 2 * count) << vertices
      << fmt::format("POINT_DATA {}\n", count) << "VECTORS force double\n"
      << force << "VECTORS friction double\n"
      << friction;
  using Value = std::function<double(const ContactView&, const ContactSpot&)>;
  const std::pair<const char*, Value> scalars[] = {
      {"normal_force", [](const ContactView&, const ContactSpot& p) { return p.force; }},
      {"overlap", [](const ContactView&, const ContactSpot& p) { return -p.gap; }},
      {"share", [](const ContactView&, const ContactSpot& p) { return p.share; }},
      {"friction_used", [](const ContactView& v, const ContactSpot&) { return v.friction_used(); }},
      {"sliding", [](const ContactView& v, const ContactSpot&) { return v.contact.sliding; }},
      {"body", [](const ContactView& v, const ContactSpot&) { return v.contact.a; }},
      {"neighbour", [](const ContactView& v, const ContactSpot&) { return v.contact.b; }},
      {"patch", [](const ContactView& v, const ContactSpot&) { return v.contact.patch; }}};
  for (const auto& [name, value] : scalars) {
    out << fmt::format("SCALARS {} double 1\nLOOKUP_TABLE default\n", name);
    for (const ContactView& view : contacts)
      for (const ContactSpot& spot : view.contact.spots)
        out << fmt::format("{}\n", value(view, spot));
  }
  out.commit();
}

}  // namespace firn
