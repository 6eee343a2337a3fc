// A small web server for one page that changes: loopback only, behind a random token.
#pragma once

#include <memory>
#include <string>

#include "reports/html/page.h"

namespace firn {

// Serves `/TOKEN/` (the page) and `/TOKEN/version` to clients of this machine. Every other path, a
// request whose Host is not this machine's loopback name, and a request from another origin are
// refused. Pages must not be stored, framed or read by other origins.
class PageServer {
 public:
  // Port 0: any free one. Throws InputError when the port cannot be bound.
  explicit PageServer(int port);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const;
  std::string address() const;  // http://127.0.0.1:PORT/TOKEN/

  // Replaces the page. Open pages load the new one within a second.
  void publish(page::Page page);
  // Whether open pages state that a newer version is being made.
  void set_busy(bool busy);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
