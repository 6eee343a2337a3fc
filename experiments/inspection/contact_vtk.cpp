#include <functional>

#include "experiments/inspection/contact_inspection.h"
#include "experiments/storage/vtk_file.h"

namespace firn {

void write_contacts_vtk(const std::vector<ContactView>& contacts, const std::string& file) {
  using Value = std::function<double(const ContactView&, const ContactPointInfo&)>;
  using Vector = std::function<Vec3(const ContactView&, const ContactPointInfo&)>;
  VtkSurface out;
  const auto add = [&](std::vector<float>& to, const Vec3& v) {
    for (const double x : v) to.push_back(static_cast<float>(x));
  };
  const auto for_points = [&](const auto& visit) {
    for (const ContactView& view : contacts) {
      for (const ContactPointInfo& spot : view.contact.points) visit(view, spot);
    }
  };
  for_points([&](const ContactView&, const ContactPointInfo& p) { add(out.points, p.position); });
  const std::pair<const char*, Vector> vectors[] = {
      {"force",
       [](const ContactView& v, const ContactPointInfo& p) { return -p.force * v.contact.normal; }},
      {"friction",
       [](const ContactView& v, const ContactPointInfo&) { return v.contact.friction; }}};
  for (const auto& vector : vectors) {
    VtkSurface::Field& field = out.fields.emplace_back(VtkSurface::Field{vector.first, 3, {}});
    for_points([&](const ContactView& v, const ContactPointInfo& p) {
      add(field.values, vector.second(v, p));
    });
  }
  const std::pair<const char*, Value> scalars[] = {
      {"normal_force", [](const ContactView&, const ContactPointInfo& p) { return p.force; }},
      {"overlap", [](const ContactView&, const ContactPointInfo& p) { return -p.gap; }},
      {"stiffness_fraction",
       [](const ContactView&, const ContactPointInfo& p) { return p.stiffness_fraction; }},
      {"friction_mobilization",
       [](const ContactView& v, const ContactPointInfo&) { return v.friction_mobilization(); }},
      {"sliding", [](const ContactView& v, const ContactPointInfo&) { return v.contact.sliding; }},
      {"body", [](const ContactView& v, const ContactPointInfo&) { return v.contact.a; }},
      {"neighbor", [](const ContactView& v, const ContactPointInfo&) { return v.contact.b; }},
      {"patch", [](const ContactView& v, const ContactPointInfo&) { return v.contact.patch; }}};
  for (const auto& scalar : scalars) {
    VtkSurface::Field& field = out.fields.emplace_back(VtkSurface::Field{scalar.first, 1, {}});
    for_points([&](const ContactView& v, const ContactPointInfo& p) {
      field.values.push_back(static_cast<float>(scalar.second(v, p)));
    });
  }
  save_vtp_points(out, file);
}

}  // namespace firn
