#include "experiments/responses/measured_part.h"

#include "experiments/case/samples.h"

namespace firn {

std::string part_group(const Case& c, const Measure& m) {
  const char* group = m.contact >= 0       ? "/boundary_contacts/"
                      : m.coupling >= 0    ? "/couplings/"
                      : m.boundary.empty() ? "/motion_frames/"
                                           : "/boundaries/";
  return group + measured_part(c, m) + "/";
}

PartRecords::PartRecords(const Recording& recording, const Case& c, const Measure& m,
                         std::initializer_list<std::string_view> quantities)
    : recording_(recording), group_(part_group(c, m)), samples_(has_samples(c, m, quantities)) {
  if (samples_) group_.insert(0, "/samples");
  times_ = samples_ ? recording.values("/samples/time") : recording.frame_times();
}

std::vector<double> PartRecords::rows(std::string_view name) const {
  const std::string path = group_ + std::string(name);
  return samples_ ? recording_.values(path) : recording_.series(path);
}

std::size_t PartRecords::regular_rows() const {
  const std::size_t n = times_.size();
  if (n < 3) return n;
  return times_[n - 1] - times_[n - 2] < (1 - 1e-6) * (times_[1] - times_[0]) ? n - 1 : n;
}

double PartRecords::interval() const {
  const std::size_t n = regular_rows();
  return (times_[n - 1] - times_[0]) / static_cast<double>(n - 1);
}

}  // namespace firn
