#include "experiments/system/temporary_folder.h"

#include <fmt/format.h>

#include <cstdlib>

#include "firn/math.h"

namespace firn {
namespace {

std::string make_folder(const std::string& name) {
  const std::filesystem::path parent =
      std::filesystem::absolute(std::filesystem::temp_directory_path());
  std::string folder = (parent / fmt::format("firn-{}-XXXXXX", name)).string();
  if (::mkdtemp(folder.data()) == nullptr)
    throw RunError(fmt::format("{}: no such folder can be made", folder));
  return folder;
}

}  // namespace

TemporaryFolder::TemporaryFolder(const std::string& name)
    : TemporaryFolder(name, interruption::Uninterrupted()) {}
TemporaryFolder::TemporaryFolder(const std::string& name, const interruption::Uninterrupted&)
    : path_(make_folder(name)), temporary_(path_.string()) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a folder left in the temporary one does no harm
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace firn
