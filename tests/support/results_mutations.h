// Results files that are almost right: one to three things of a good one are changed, so that HDF5
// can read it and the schema cannot accept it - or can.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace firn::test {

// Numbers that decide what is changed: of a random generator, or of the bytes of a fuzzer.
using Draw = std::function<std::size_t(std::size_t below)>;

// Closes an HDF5 object of any kind.
class Hid {
 public:
  explicit Hid(hid_t id) : id_(id) {}
  ~Hid() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  Hid(const Hid&) = delete;
  Hid& operator=(const Hid&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
};

class ResultsMutator {
 public:
  ResultsMutator(const std::string& file, Draw draw) : draw_(std::move(draw)), file_(open(file)) {
    H5Ovisit2(file_, H5_INDEX_NAME, H5_ITER_INC, collect, &paths_, H5O_INFO_BASIC);
    std::sort(paths_.begin(), paths_.end());
  }
  ~ResultsMutator() { H5Fclose(file_); }
  ResultsMutator(const ResultsMutator&) = delete;
  ResultsMutator& operator=(const ResultsMutator&) = delete;

  // Returns what it did.
  std::string mutate() {
    std::string did;
    for (std::size_t left = 1 + draw_(3); left > 0; --left) {
      if (paths_.empty()) break;
      path_ = paths_[draw_(paths_.size())];
      if (H5Lexists(file_, path_.c_str(), H5P_DEFAULT) <= 0) continue;
      did += path_ + ": " + once() + "; ";
    }
    return did;
  }

  // Replaces a dataset by one with this space and type, of the same values as far as they go.
  void replace(const std::string& path, const std::vector<hsize_t>& shape, hid_t type,
               H5S_class_t kind = H5S_SIMPLE) {
    const Hid old(H5Dopen2(file_, path.c_str(), H5P_DEFAULT));
    if (old < 0) return;
    const Hid old_type(H5Dget_type(old)), old_space(H5Dget_space(old));
    const bool text = H5Tget_class(old_type) == H5T_STRING;
    const auto count =
        static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(old_space)));
    std::size_t wanted = kind == H5S_NULL ? 0 : 1;
    if (kind == H5S_SIMPLE)
      for (const hsize_t n : shape) wanted *= n;
    if (wanted > 1000000) return;
    std::vector<std::uint64_t> values(4 * std::max(count, wanted) + 4, 0);
    if (!text && count > 0) H5Dread(old, old_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    std::vector<std::string> units = {text_attribute(old, "unit")};
    H5Ldelete(file_, path.c_str(), H5P_DEFAULT);
    const Hid space(kind == H5S_SIMPLE && !shape.empty()
                        ? H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr)
                        : H5Screate(kind == H5S_NULL ? H5S_NULL : H5S_SCALAR));
    const Hid made(
        H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    if (made < 0) return;
    if (H5Tget_class(type) != H5T_STRING && wanted > 0 && H5Tget_size(type) <= 32)
      H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    if (!units[0].empty()) set_text(path, "unit", units[0]);
  }

  // Overwrites values of a dataset of numbers from an entry on.
  void overwrite(const std::string& path, std::size_t from, std::size_t count, double value) {
    const Hid data(H5Dopen2(file_, path.c_str(), H5P_DEFAULT));
    if (data < 0) return;
    const Hid type(H5Dget_type(data)), space(H5Dget_space(data));
    if (H5Tget_class(type) != H5T_FLOAT && H5Tget_class(type) != H5T_INTEGER) return;
    const auto n =
        static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
    if (n == 0 || from >= n) return;
    std::vector<double> values(n);
    H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    for (std::size_t i = from; i < std::min(n, from + count); ++i) values[i] = value;
    H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }

  void set_text(const std::string& path, const char* name, const std::string& value) {
    const Hid object(H5Oopen(file_, path.c_str(), H5P_DEFAULT));
    if (object < 0) return;
    H5Adelete(object, name);
    const Hid type(text_type()), space(H5Screate(H5S_SCALAR));
    const Hid attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
    const char* text = value.c_str();
    H5Awrite(attribute, type, &text);
  }

  void remove(const std::string& path) { H5Ldelete(file_, path.c_str(), H5P_DEFAULT); }

  void nest_groups(const std::string& path, std::size_t depth) {
    const Hid parents(H5Pcreate(H5P_LINK_CREATE));
    H5Pset_create_intermediate_group(parents, 1);
    hid_t at = H5Gcreate2(file_, path.c_str(), parents, H5P_DEFAULT, H5P_DEFAULT);
    for (std::size_t i = 0; i < depth && at >= 0; ++i) {
      const hid_t next = H5Gcreate2(at, "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      H5Gclose(at);
      at = next;
    }
    if (at >= 0) H5Gclose(at);
  }

  std::vector<hsize_t> shape_of(const std::string& path) const {
    const Hid data(H5Dopen2(file_, path.c_str(), H5P_DEFAULT));
    const Hid space(data < 0 ? -1 : H5Dget_space(data));
    const int rank = space < 0 ? 0 : H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(rank, 0)));
    if (rank > 0) H5Sget_simple_extent_dims(space, shape.data(), nullptr);
    return shape;
  }

  const std::vector<std::string>& paths() const { return paths_; }
  hid_t file() const { return file_; }

 private:
  static hid_t open(const std::string& file) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const Hid access(H5Pcreate(H5P_FILE_ACCESS));
    H5Pset_file_locking(access, false, true);
    return H5Fopen(file.c_str(), H5F_ACC_RDWR, access);
  }

  static herr_t collect(hid_t, const char* name, const H5O_info_t* info, void* out) {
    if (info->type == H5O_TYPE_DATASET)
      static_cast<std::vector<std::string>*>(out)->push_back(std::string("/") + name);
    return 0;
  }

  static hid_t text_type() {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
  }

  static std::string text_attribute(hid_t object, const char* name) {
    if (H5Aexists(object, name) <= 0) return "";
    const Hid attribute(H5Aopen(object, name, H5P_DEFAULT));
    const Hid type(H5Aget_type(attribute)), space(H5Aget_space(attribute));
    if (H5Tis_variable_str(type) <= 0 || H5Sget_simple_extent_npoints(space) != 1) return "";
    char* text = nullptr;
    if (H5Aread(attribute, type, &text) < 0 || !text) return "";
    std::string value = text;
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, &text);
    return value;
  }

  hid_t stored_type() const {
    const Hid data(H5Dopen2(file_, path_.c_str(), H5P_DEFAULT));
    return H5Dget_type(data);
  }

  std::string once() {
    switch (draw_(11)) {
      case 0:
        remove(path_);
        return "removed";
      case 1:
      case 2:
        return resize();
      case 3:
        return retype();
      case 4:
      case 5:
      case 6:
        return revalue();
      case 7:
        return change_attribute();
      case 8:
        return change_links();
      case 9:
        return change_text();
      default:
        return change_case();
    }
  }

  std::string resize() {
    std::vector<hsize_t> shape = shape_of(path_);
    const Hid type(stored_type());
    const std::size_t how = draw_(9);
    if (how == 0 || shape.empty()) {
      replace(path_, {}, type, draw_(2) ? H5S_NULL : H5S_SCALAR);
      return "without a shape";
    }
    hsize_t& n = shape[draw_(shape.size())];
    switch (how) {
      case 1:
        n = n / 2;
        break;
      case 2:
        n = n + 1;
        break;
      case 3:
        n = n > 0 ? n - 1 : 7;
        break;
      case 4:
        n = 0;
        break;
      case 5:
        n = 2 * n;
        break;
      case 6:
        shape.push_back(1);
        break;
      case 7:
        shape.pop_back();
        break;
      default:
        std::reverse(shape.begin(), shape.end());
    }
    replace(path_, shape, type);
    return "another shape";
  }

  std::string retype() {
    const std::vector<hsize_t> shape = shape_of(path_);
    const Hid text(text_type()), fixed(H5Tcopy(H5T_C_S1)), opaque(H5Tcreate(H5T_OPAQUE, 5)),
        compound(H5Tcreate(H5T_COMPOUND, 8)), odd(H5Tcopy(H5T_NATIVE_INT));
    H5Tset_size(fixed, 9);
    H5Tinsert(compound, "x", 0, H5T_NATIVE_DOUBLE);
    H5Tset_precision(odd, 11);
    const hid_t types[] = {H5T_NATIVE_INT8,
                           H5T_NATIVE_UINT32,
                           H5T_STD_I64BE,
                           H5T_NATIVE_UINT64,
                           H5T_IEEE_F32LE,
                           H5T_IEEE_F64BE,
                           H5T_STD_I32BE,
                           H5T_NATIVE_INT,
                           H5T_NATIVE_DOUBLE,
                           text,
                           fixed,
                           opaque,
                           compound,
                           odd,
                           H5T_STD_B8LE};
    const std::size_t k = draw_(std::size(types));
    replace(path_, shape, types[k]);
    return "another type, " + std::to_string(k);
  }

  std::string revalue() {
    constexpr double kValues[] = {std::numeric_limits<double>::quiet_NaN(),
                                  std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity(),
                                  -1,
                                  -2,
                                  0,
                                  1,
                                  0.5,
                                  1e-300,
                                  5e-324,
                                  1e6,
                                  1e30,
                                  1e150,
                                  -1e300,
                                  1.7e308,
                                  2147483647,
                                  -2147483648.0,
                                  3};
    const double value = kValues[draw_(std::size(kValues))];
    const std::vector<hsize_t> shape = shape_of(path_);
    std::size_t n = 1;
    for (const hsize_t k : shape) n *= k;
    const std::size_t from = n > 0 ? draw_(n) : 0;
    const std::size_t counts[] = {1, 1, 3, 4, n};
    const std::size_t count = counts[draw_(5)];
    overwrite(path_, count == n ? 0 : from, count, value);
    char text[64];
    std::snprintf(text, sizeof(text), "%zu values from %zu are %g", count, from, value);
    return text;
  }

  std::string change_attribute() {
    const char* const names[] = {"unit",       "status",         "timestep",
                                 "seed",       "method",         "responses_complete",
                                 "wall_time",  "uncertainty",    "firn_version",
                                 "git_commit", "method_version", "case"};
    const char* const name = names[draw_(std::size(names))];
    const Hid own(H5Oopen(file_, path_.c_str(), H5P_DEFAULT));
    const bool here = H5Aexists(own, name) > 0;
    const Hid object(H5Oopen(file_, here ? path_.c_str() : "/", H5P_DEFAULT));
    const std::string what = std::string("attribute ") + name + (here ? "" : " of the file");
    H5Adelete(object, name);
    const std::size_t how = draw_(7);
    if (how == 0) return what + " removed";
    if (how == 1) {
      set_text(here ? path_ : "/", name, draw_(2) ? "finished" : "failed: x");
      return what + " is text";
    }
    const hsize_t two = 2;
    const Hid space(how == 2   ? H5Screate(H5S_NULL)
                    : how == 3 ? H5Screate_simple(1, &two, nullptr)
                               : H5Screate(H5S_SCALAR));
    const Hid attribute(H5Acreate2(object, name, how == 6 ? H5T_NATIVE_UINT64 : H5T_NATIVE_DOUBLE,
                                   space, H5P_DEFAULT, H5P_DEFAULT));
    const double values[] = {how == 4 ? -1 : 1e-5, std::nan("")};
    const std::uint64_t whole = 1;
    if (how == 6)
      H5Awrite(attribute, H5T_NATIVE_UINT64, &whole);
    else if (how != 2)
      H5Awrite(attribute, H5T_NATIVE_DOUBLE, values);
    return what + " changed, " + std::to_string(how);
  }

  std::string change_links() {
    switch (draw_(7)) {
      case 0:
        nest_groups(path_ + ".group", 3 + draw_(200));
        return "groups next to it";
      case 1:
        remove(path_);
        nest_groups(path_, 1 + draw_(3));
        return "a group";
      case 2: {
        const std::string other = paths_[draw_(paths_.size())];
        remove(path_);
        H5Lcreate_hard(file_, other.c_str(), file_, path_.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        return "is " + other;
      }
      case 3:
        remove(path_);
        H5Lcreate_soft("/frames/time", file_, path_.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        return "soft link";
      case 4:
        remove(path_);
        H5Lcreate_external("/etc/passwd", "/x", file_, path_.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        return "external link";
      case 5:
        H5Lcreate_hard(file_, "/", file_, (path_ + ".loop").c_str(), H5P_DEFAULT, H5P_DEFAULT);
        return "a loop next to it";
      default: {
        const std::string other = paths_[draw_(paths_.size())];
        H5Lmove(file_, path_.c_str(), file_, (path_ + ".moved").c_str(), H5P_DEFAULT, H5P_DEFAULT);
        H5Lmove(file_, other.c_str(), file_, path_.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        H5Lmove(file_, (path_ + ".moved").c_str(), file_, other.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        return "exchanged with " + other;
      }
    }
  }

  std::string change_text() {
    const Hid data(H5Dopen2(file_, path_.c_str(), H5P_DEFAULT));
    const Hid type(H5Dget_type(data)), space(H5Dget_space(data));
    if (H5Tis_variable_str(type) <= 0) return revalue();
    const auto n =
        static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
    const std::string long_text(5000, 'x');
    const char* const texts[] = {"",    "high",   "\x1b[31m", "a\nb", "\xff\xfe", long_text.c_str(),
                                 "nan", "intact", "tension",  "../x", nullptr};
    std::vector<const char*> values(n, texts[draw_(std::size(texts))]);
    if (n > 0) H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    return "another text";
  }

  // The case in the file is another one than was run.
  std::string change_case() {
    std::string text;
    {
      const Hid root(H5Oopen(file_, "/", H5P_DEFAULT));
      text = text_attribute(root, "case");
    }
    const std::pair<const char*, const char*> edits[] = {
        {"count = 2", "count = 3"},
        {"name = \"high\"", "name = \"low2\""},
        {"name = \"side\"", "name = \"x\""},
        {"batches = 2", "batches = 1"},
        {"pairs = [ [ 0, 1 ] ]", "pairs = [ [ 1, 2 ] ]"},
        {"\"pebble\"", "\"cube\""},
        {"name = \"arm\"", "name = \"leg\""},
        {"name = \"panel\"", "name = \"wall\""},
        {"columns = 2", "columns = 5"},
        {"free_rotation = true", "free_rotation = false"},
        {"name = \"hold\"", "name = \"end\""}};
    const auto& [from, to] = edits[draw_(std::size(edits))];
    const std::size_t at = text.find(from);
    if (at == std::string::npos) return "the case stays";
    text.replace(at, std::strlen(from), to);
    set_text("/", "case", text);
    return std::string("the case has ") + to;
  }

  Draw draw_;
  hid_t file_;
  std::vector<std::string> paths_;
  std::string path_;
};

}  // namespace firn::test
