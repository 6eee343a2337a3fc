#include "experiments/batch/batch_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "experiments/batch/slurm/slurm_executor.h"
#include "experiments/storage/sha256.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Executor> make_executor(const std::string& directory, const BatchOptions& options,
                                        const SlurmSettings& settings, Journal& journal) {
  if (options.executor == "local")
    return local_executor({options.program, options.jobs, options.interrupt});
  if (options.executor != "slurm")
    throw InputError(
        fmt::format("--executor: \"{}\" is not known; expected local or slurm", options.executor));
  SlurmOptions slurm;
  slurm.settings = settings;
  slurm.program = options.program;
  slurm.folder = (fs::absolute(directory) / "slurm").lexically_normal().string();
  slurm.at_once = options.jobs;
  slurm.interrupt = options.interrupt;
  return slurm_executor(slurm, journal);
}

int concurrent_runs(const BatchOptions& options) {
  if (options.jobs > 0 || options.executor != "local") return options.jobs;
  return static_cast<int>(std::thread::hardware_concurrency());
}

ProgressStyle progress_style(const BatchOptions& options) {
  if (!options.show_progress) return ProgressStyle::none;
  return options.json_progress ? ProgressStyle::json : ProgressStyle::text;
}

}  // namespace

DirectoryLock::DirectoryLock(const std::string& directory) {
  const std::string file = (fs::path(directory) / "lock").string();
  descriptor_ = open(file.c_str(), O_RDWR | O_CREAT, 0644);
  if (descriptor_ < 0) refuse_output(file, errno);
  for (int tries = 0; flock(descriptor_, LOCK_EX | LOCK_NB) != 0; ++tries) {
    pid_t owner = 0;
    std::ifstream(file) >> owner;
    if (tries == 300 || (tries == 10 && owner > 0 && kill(owner, 0) == 0)) {
      close(descriptor_);
      throw InputError(
          fmt::format("{}: another process is at work here; expected it to end "
                      "first, or another directory with -o",
                      directory));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const std::string owner = fmt::format("{}\n", getpid());
  if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) {
    const int error = errno;
    close(descriptor_);
    throw WriteError(file, error);
  }
}

DirectoryLock::~DirectoryLock() { close(descriptor_); }

BatchFolder::BatchFolder(const std::string& directory, const BatchContent& content,
                         const BatchOptions& options)
    : runs_((fs::absolute(directory) / "runs").lexically_normal().string()) {
  journal_file(directory, options.resume);  // the directory is there
  lock_.emplace(directory);                 // before the journal, which a batch at work may hold
  journal_.emplace(directory, content.identity, options.resume);
  if (!options.store.empty()) store_.emplace(options.store, sha256(content.identity));
  if (options.replace_executor == nullptr)
    own_ = make_executor(directory, options, content.slurm, *journal_);
  progress_.emplace(progress_style(options), content.kind, content.largest_total,
                    concurrent_runs(options), &*journal_);
  executor_ = own_ ? own_.get() : options.replace_executor;
}

}  // namespace firn
