#include "experiments/storage/hdf5_objects.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <string>
#include <unordered_set>
#include <utility>

#include "experiments/storage/hdf5_library.h"

namespace firn::hdf5 {
namespace {

constexpr std::size_t kDeepest = 32;  // links from the root
constexpr std::size_t kMostObjects = 100000;

struct Links {
  std::vector<std::string> names;
  bool odd = false;  // a link that is not hard
};

herr_t collect_link(hid_t, const char* name, const H5L_info_t* info, void* out) {
  auto& links = *static_cast<Links*>(out);
  links.names.emplace_back(name);
  if (info->type != H5L_TYPE_HARD) {
    links.odd = true;
    return 1;
  }
  return links.names.size() > kMostObjects ? 1 : 0;
}

// Visits the groups of a file once, those near the root first.
class Walk {
 public:
  explicit Walk(hid_t file) {
    const Handle root = own(H5Gopen2(file, "/", H5P_DEFAULT), "open the root group");
    note(root.id(), "/");
    list(root.id(), "", 1);
    for (std::size_t next = 0; next < groups_.size(); ++next) {
      const auto [path, depth] = groups_[next];
      const Handle group = own(H5Gopen2(file, path.c_str(), H5P_DEFAULT), "open " + path);
      list(group.id(), path, depth + 1);
    }
  }

  std::vector<Object> objects;

 private:
  // Throws for an object that has been seen under another name.
  H5O_type_t note(hid_t object, const std::string& path) {
    H5O_info_t info;
    check(H5Oget_info2(object, &info, H5O_INFO_BASIC), "look at " + path);
    if (!seen_.insert(info.addr).second)
      throw Error(path + ": is a second name of another object; expected one name each");
    return info.type;
  }

  void list(hid_t group, const std::string& path, std::size_t depth) {
    Links links;
    hsize_t from = 0;
    check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &from, collect_link, &links),
          fmt::format("list {}", path.empty() ? "/" : path));
    for (const std::string& name : links.names) check_printable(name, "a name");
    if (links.odd)
      throw Error(fmt::format("{}/{}: is a link to elsewhere; expected a dataset or a group", path,
                              links.names.back()));
    if (objects.size() + links.names.size() > kMostObjects)
      throw Error(fmt::format("{}: holds too many objects; expected at most {} in the file",
                              path.empty() ? "/" : path, kMostObjects));
    for (const std::string& name : links.names) add(group, name, path + "/" + name, depth);
  }

  void add(hid_t group, const std::string& name, const std::string& path, std::size_t depth) {
    if (depth > kDeepest)
      throw Error(fmt::format("{}: is {} groups deep; expected at most {}", path, depth, kDeepest));
    const Handle object = own(H5Oopen(group, name.c_str(), H5P_DEFAULT), "open " + path);
    Object found;
    found.path = path;
    switch (note(object.id(), path)) {
      case H5O_TYPE_GROUP:
        found.is_group = true;
        groups_.emplace_back(path, depth);
        break;
      case H5O_TYPE_DATASET: {
        const Handle type = own(H5Dget_type(object.id()), "read the type of " + path);
        const Handle space = own(H5Dget_space(object.id()), "read the shape of " + path);
        found.type = type_of(type.id());
        found.has_space = has_extent(space.id());
        if (found.has_space) found.shape = shape_of_space(space.id());
        break;
      }
      default:
        throw Error(path + ": is neither a dataset nor a group; expected one of them");
    }
    objects.push_back(std::move(found));
  }

  std::unordered_set<haddr_t> seen_;
  std::vector<std::pair<std::string, std::size_t>> groups_;  // still to be listed, and their depth
};

}  // namespace

std::vector<Object> list_objects(Id file) { return std::move(Walk(file).objects); }

}  // namespace firn::hdf5
