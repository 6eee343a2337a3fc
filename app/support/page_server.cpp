#include "app/support/page_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <openssl/rand.h>

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <string_view>
#include <thread>

#undef _res  // a macro of <resolv.h>, which Eigen uses as a name

#include "firn/math.h"
#include "reports/html/assets.h"

namespace firn {
namespace {

constexpr const char* kHost = "127.0.0.1";

std::string random_token() {
  std::array<unsigned char, 16> bytes;
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    throw RunError("view: the system has no random numbers for the address");
  std::string token;
  for (const unsigned char b : bytes) token += fmt::format("{:02x}", b);
  return token;
}

// The host part of `HOST[:PORT]`.
std::string_view host_of(std::string_view text) {
  if (text.starts_with("[")) return text.substr(0, text.find(']') + 1);
  return text.substr(0, text.find(':'));
}

// Names under which a browser reaches this machine, also through a forwarded port. A page of
// another origin that points its own name at this address (DNS rebinding) has another one.
bool is_loopback_name(std::string_view host) {
  return host == "127.0.0.1" || host == "localhost" || host == "[::1]";
}

bool is_own_origin(const httplib::Request& request) {
  if (!request.has_header("Origin")) return true;
  return request.get_header_value("Origin") == "http://" + request.get_header_value("Host");
}

}  // namespace

struct PageServer::Impl {
  httplib::Server server;
  std::thread thread;
  std::string token = random_token();
  int port = 0;
  std::mutex mutex;
  std::string html;
  std::atomic<int> version = 0;
  std::atomic<bool> busy = false;

  void refuse(httplib::Response& response, int status) const {
    response.status = status;
    response.set_content(status == 404 ? "not found\n" : "refused\n", "text/plain");
  }

  void set_up() {
    server.set_default_headers({{"Cache-Control", "no-store"},
                                {"X-Content-Type-Options", "nosniff"},
                                {"X-Frame-Options", "DENY"},
                                {"Referrer-Policy", "no-referrer"},
                                {"Cross-Origin-Resource-Policy", "same-origin"},
                                {"Cross-Origin-Opener-Policy", "same-origin"}});
    server.set_payload_max_length(1024);
    server.set_read_timeout(10);
    server.set_write_timeout(30);
    server.set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
          if (request.method != "GET" && request.method != "HEAD") {
            refuse(response, 405);
          } else if (!is_loopback_name(host_of(request.get_header_value("Host"))) ||
                     !is_own_origin(request)) {
            refuse(response, 403);
          } else if (request.path == "/" + token + "/") {
            const std::lock_guard lock(mutex);
            response.set_content(html, "text/html; charset=utf-8");
          } else if (request.path == "/" + token + "/version") {
            response.set_content(
                fmt::format("{{\"version\": {}, \"busy\": {}}}\n", version.load(), busy.load()),
                "application/json");
          } else {
            refuse(response, 404);
          }
          return httplib::Server::HandlerResponse::Handled;
        });
  }
};

PageServer::PageServer(int port) : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  s.set_up();
  if (port == 0)
    s.port = s.server.bind_to_any_port(kHost);
  else
    s.port = s.server.bind_to_port(kHost, port) ? port : -1;
  if (s.port <= 0)
    throw InputError(
        fmt::format("--port: {} cannot be bound; expected a free port, or 0 for any", port));
  s.thread = std::thread([&s] { s.server.listen_after_bind(); });
  // stop() has no effect on a server that does not listen yet.
  while (!s.server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

PageServer::~PageServer() {
  impl_->server.stop();
  impl_->thread.join();
}

int PageServer::port() const { return impl_->port; }

std::string PageServer::address() const {
  return fmt::format("http://{}:{}/{}/", kHost, impl_->port, impl_->token);
}

void PageServer::publish(page::Page page) {
  const int version = impl_->version + 1;
  page.allow_requests_to_its_server();
  page.top().html(
      fmt::format("<div id=\"live\" role=\"status\" data-version=\"{}\" hidden></div>\n", version));
  page.add_script(asset("live.js"));
  std::string html = page.html();
  const std::lock_guard lock(impl_->mutex);
  impl_->html = std::move(html);
  impl_->version = version;
}

void PageServer::set_busy(bool busy) { impl_->busy = busy; }

}  // namespace firn
