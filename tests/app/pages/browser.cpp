#include "tests/app/pages/browser.h"

#include <fcntl.h>
#include <httplib.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#undef _res  // a macro of <resolv.h>, which Eigen uses as a name

#include <stdexcept>
#include <thread>

#include "experiments/system/input_file.h"
#include "tests/support/scratch_folder.h"

extern char** environ;

namespace firn::cli {

using Json = nlohmann::json;

struct Browser::Impl {
  test::ScratchFolder folder{"browser"};
  pid_t driver = 0;
  std::unique_ptr<httplib::Client> client;
  std::string session;

  Json ask(const std::string& method, const std::string& path, const Json& body = Json::object()) {
    const httplib::Result result =
        method == "POST"     ? client->Post("/session" + path, body.dump(), "application/json")
        : method == "DELETE" ? client->Delete("/session" + path)
                             : client->Get("/session" + path);
    if (!result) throw std::runtime_error("chromedriver does not answer");
    const Json answer = Json::parse(result->body);
    if (result->status != 200) throw std::runtime_error(answer.dump());
    return answer.at("value");
  }

  // The port that the driver has chosen, from its log.
  int start_driver() {
    const std::string log = folder / "driver.log";
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    char program[] = "chromedriver", port[] = "--port=0";
    char* arguments[] = {program, port, nullptr};
    const int error = ::posix_spawnp(&driver, program, &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("chromedriver cannot be started");
    for (int i = 0; i < 300; ++i) {
      const std::string said = read_own_file(log), before = "started successfully on port ";
      const std::size_t at = said.find(before);
      if (at != said.npos && said.find('.', at) != said.npos)
        return std::stoi(said.substr(at + before.size()));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    throw std::runtime_error("chromedriver does not start");
  }
};

Browser::Browser() : impl_(std::make_unique<Impl>()) {
  Impl& b = *impl_;
  b.client = std::make_unique<httplib::Client>("127.0.0.1", b.start_driver());
  b.client->set_read_timeout(120);
  const Json options = {{"args",
                         {"--headless", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle",
                          "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                          "--window-size=1200,1000", "--user-data-dir=" + (b.folder / "profile")}}};
  const Json wanted = {{"capabilities",
                        {{"alwaysMatch",
                          {{"browserName", "chrome"},
                           {"goog:chromeOptions", options},
                           {"goog:loggingPrefs", {{"browser", "ALL"}}}}}}}};
  b.session = "/" + b.ask("POST", "", wanted).at("sessionId").get<std::string>();
}

Browser::~Browser() {
  try {
    if (!impl_->session.empty()) impl_->ask("DELETE", impl_->session);
  } catch (const std::exception&) {
  }
  if (impl_->driver > 0) {
    ::kill(impl_->driver, SIGTERM);
    ::waitpid(impl_->driver, nullptr, 0);
  }
}

void Browser::open(const std::string& url) {
  impl_->ask("POST", impl_->session + "/url", {{"url", url}});
}

Json Browser::value(const std::string& expression) {
  return impl_->ask("POST", impl_->session + "/execute/sync",
                    {{"script", "return (" + expression + ");"}, {"args", Json::array()}});
}

bool Browser::becomes(const std::string& expression, std::chrono::milliseconds within) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (std::chrono::steady_clock::now() < until) {
    try {
      if (value("Boolean(" + expression + ")").get<bool>()) return true;
    } catch (const std::runtime_error&) {  // between two pages
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

void Browser::resize(int width, int height) {
  impl_->ask("POST", impl_->session + "/window/rect", {{"width", width}, {"height", height}});
}

void Browser::press(const std::string& keys) {
  const Json element = impl_->ask("GET", impl_->session + "/element/active");
  impl_->ask("POST",
             impl_->session + "/element/" + element.begin().value().get<std::string>() + "/value",
             {{"text", keys}});
}

std::string Browser::console_errors() {
  std::string errors;
  for (const Json& entry : impl_->ask("POST", impl_->session + "/se/log", {{"type", "browser"}})) {
    if (entry.at("level") == "SEVERE") errors += entry.at("message").get<std::string>() + "\n";
  }
  return errors;
}

}  // namespace firn::cli
