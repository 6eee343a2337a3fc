#include "library/experiments/case_facade.h"

#include "experiments/case_reader/read_case.h"

namespace firn::experiments {
namespace {

std::shared_ptr<const Case::Impl> read(Case::Impl impl) {
  impl.checked = impl.file.empty() ? read_case_text(impl.text, "case text", impl.directory,
                                                    impl.overrides, impl.materials)
                                   : read_case(impl.file, impl.overrides, impl.materials);
  return std::make_shared<const Case::Impl>(std::move(impl));
}

}  // namespace

Case Case::load(const std::string& file, const std::vector<Override>& overrides,
                const std::vector<std::string>& material_records) {
  return Case(read({file, {}, {}, overrides, {material_records, {}}, {}}));
}

Case Case::parse(const std::string& text, const std::string& directory,
                 const std::vector<Override>& overrides) {
  return Case(read({{}, text, directory, overrides, {}, {}}));
}

Case Case::with(const std::vector<Override>& overrides) const {
  std::vector<Override> all = impl_->overrides;
  all.insert(all.end(), overrides.begin(), overrides.end());
  return Case(read({impl_->file, impl_->text, impl_->directory, all, impl_->materials, {}}));
}

std::string Case::name() const { return impl_->checked.name; }
double Case::duration() const { return impl_->checked.duration; }
std::uint64_t Case::seed() const { return impl_->checked.seed; }
double Case::timestep() const { return impl_->checked.model.timestep; }
double Case::frame_interval() const { return impl_->checked.frame_interval; }
const Model& Case::model() const { return impl_->checked.model; }
std::string Case::text() const { return impl_->checked.resolved; }

}  // namespace firn::experiments
