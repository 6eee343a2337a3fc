#include "tests/app/robustness/io_faults.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>

namespace firn::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 4096;  // bytes that a device writes at once

// A file system that remembers what of it is on the device.
class Device {
 public:
  void apply(const IoCall& call) {
    switch (call.kind) {
      case 'C':
        names_[call.path] = std::make_shared<File>();
        changes_.push_back(call);
        created_.push_back(names_[call.path]);
        break;
      case 'W':
      case 'T':
        if (const auto file = names_.find(call.path); file != names_.end()) {
          change(file->second->now, call);
          file->second->unsynced.push_back(call);
        }
        break;
      case 'S':
        if (const auto file = names_.find(call.path); file != names_.end()) {
          file->second->synced = file->second->now;
          file->second->unsynced.clear();
        } else {  // the folder
          names_synced_ = names_;
          changes_.clear();
          created_.clear();
        }
        break;
      case 'R':
        names_[call.other] = names_[call.path];
        names_.erase(call.path);
        changes_.push_back(call);
        break;
      case 'U':
        names_.erase(call.path);
        changes_.push_back(call);
        break;
      default:
        throw std::runtime_error("not a record of calls");
    }
  }

  Files everything() const {
    return contents(names_, [](const File& f) { return f.now; });
  }
  Files synced() const {
    return contents(names_synced_, [](const File& f) { return f.synced; });
  }

  Files some(std::mt19937_64& random) const {
    Names names = names_synced_;
    auto created = created_.begin();
    const std::size_t changed = random() % (changes_.size() + 1);
    for (std::size_t i = 0; i < changed; ++i) {
      const IoCall& call = changes_[i];
      if (call.kind == 'C') names[call.path] = *created++;
      if (call.kind == 'R' && names.contains(call.path)) {
        names[call.other] = names[call.path];
        names.erase(call.path);
      }
      if (call.kind == 'U') names.erase(call.path);
    }
    return contents(names, [&](const File& f) {
      std::string text = f.synced;
      for (IoCall call : f.unsynced) {
        if (call.kind == 'T') {
          if (random() % 2) change(text, call);
          continue;
        }
        for (std::size_t at = 0; at < call.bytes.size(); at += kBlock) {
          IoCall part{'W', call.path, "", call.offset + at, call.bytes.substr(at, kBlock)};
          if (random() % 2) change(text, part);
        }
      }
      return text;
    });
  }

 private:
  struct File {
    std::string now, synced;
    std::vector<IoCall> unsynced;
  };
  using Names = std::map<std::string, std::shared_ptr<File>>;

  static void change(std::string& text, const IoCall& call) {
    if (call.kind == 'T') return text.resize(call.offset);
    text.resize(std::max(text.size(), static_cast<std::size_t>(call.offset) + call.bytes.size()));
    std::memcpy(text.data() + call.offset, call.bytes.data(), call.bytes.size());
  }

  template <class Text>
  static Files contents(const Names& names, Text&& text) {
    Files files;
    for (const auto& [path, file] : names) files[path] = text(*file);
    return files;
  }

  Names names_, names_synced_;
  std::vector<IoCall> changes_;                 // of names, since the last sync of the folder
  std::vector<std::shared_ptr<File>> created_;  // by these changes, in their order
};

Device device_after(const std::vector<IoCall>& calls, std::size_t count) {
  Device device;
  for (std::size_t i = 0; i < count; ++i) device.apply(calls[i]);
  return device;
}

}  // namespace

bool io_shim_works() {
#if defined(__SANITIZE_THREAD__)
  return false;
#else
  return true;
#endif
}

void load_io_shim() {
  setenv("LD_PRELOAD", FIRN_IO_SHIM, 1);
#if defined(__SANITIZE_ADDRESS__)
  // Otherwise the sanitizer refuses a library that is loaded before its own.
  const char* const options = std::getenv("ASAN_OPTIONS");
  const std::string more = options == nullptr ? "" : std::string(options) + ":";
  setenv("ASAN_OPTIONS", (more + "verify_asan_link_order=0").c_str(), 1);
#endif
}

CountedOutcome firn_with(const Folder& folder, const IoFaults& faults,
                         const std::vector<std::string>& arguments) {
  const fs::path count = folder.path() / ".count";
  std::ofstream(count, std::ios::binary) << std::string(8, '\0');
  const pid_t pid = folder.start(arguments, [&] {
    load_io_shim();
    setenv("FIRN_IO_FOLDER", faults.folder.c_str(), 1);
    setenv("FIRN_IO_COUNT", count.c_str(), 1);
    if (const auto& f = faults.fail)
      setenv("FIRN_IO_FAIL",
             (std::to_string(f->first) + ":" + std::to_string(f->error) + ":" +
              std::to_string(f->calls))
                 .c_str(),
             1);
    if (const auto& s = faults.signal)
      setenv("FIRN_IO_SIGNAL", (std::to_string(s->at) + ":" + std::to_string(s->signal)).c_str(),
             1);
    if (!faults.log.empty()) setenv("FIRN_IO_LOG", faults.log.c_str(), 1);
  });
  CountedOutcome outcome{folder.wait(pid), 0};
  std::ifstream(count, std::ios::binary).read(reinterpret_cast<char*>(&outcome.calls), 8);
  return outcome;
}

std::vector<IoCall> read_io_log(const std::string& file) {
  const std::string text = read_text(file);
  std::size_t at = 0;
  const auto take = [&](std::uint64_t size) {
    if (size > text.size() - at) throw std::runtime_error(file + ": ends too early");
    at += size;
    return text.substr(at - size, size);
  };
  const auto number = [&] {
    std::uint64_t n = 0;
    std::memcpy(&n, take(8).data(), 8);
    return n;
  };
  std::vector<IoCall> calls;
  while (at < text.size()) {
    IoCall& call = calls.emplace_back();
    call.kind = take(1)[0];
    call.path = take(number());
    call.other = take(number());
    call.offset = number();
    call.bytes = take(number());
  }
  return calls;
}

Files after_kill(const std::vector<IoCall>& calls, std::size_t count) {
  return device_after(calls, count).everything();
}

Files after_power_failure(const std::vector<IoCall>& calls, std::size_t count) {
  return device_after(calls, count).synced();
}

Files after_power_failure(const std::vector<IoCall>& calls, std::size_t count,
                          std::mt19937_64& random) {
  return device_after(calls, count).some(random);
}

}  // namespace firn::cli
