#include "tests/app/program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "experiments/system/input_file.h"

namespace firn::cli {

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

std::size_t lines_with(const std::string& text, const std::string& part) {
  std::istringstream all(text);
  std::size_t count = 0;
  for (std::string line; std::getline(all, line);) count += line.find(part) != std::string::npos;
  return count;
}

std::string Folder::write(const std::string& name, const std::string& text) const {
  std::ofstream(path() / name, std::ios::binary) << text;
  return name;
}

pid_t Folder::start(const std::vector<std::string>& arguments,
                    const std::function<void()>& prepare) const {
  std::vector<std::string> words = {FIRN_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string out = (path() / ".out").string();
  const std::string err = (path() / ".err").string();
  const pid_t pid = fork();
  if (pid != 0) return pid;
  const int mode = O_WRONLY | O_CREAT | O_TRUNC;
  const bool ready = chdir(path().c_str()) == 0 && dup2(open(out.c_str(), mode, 0600), 1) == 1 &&
                     dup2(open(err.c_str(), mode, 0600), 2) == 2;
  if (ready && prepare) prepare();
  if (ready) execv(argv[0], argv.data());
  _exit(127);
}

Outcome Folder::wait(pid_t pid) const {
  int status = 0;
  waitpid(pid, &status, 0);
  // A process that was killed at once has not opened them.
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          read_own_file((path() / ".out").string()), read_own_file((path() / ".err").string()),
          WIFSIGNALED(status) ? WTERMSIG(status) : 0};
}

Outcome Folder::firn(const std::vector<std::string>& arguments) const {
  return wait(start(arguments));
}

}  // namespace firn::cli
