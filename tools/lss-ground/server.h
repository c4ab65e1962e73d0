#pragma once

// HTTP and WebSocket (libwebsockets): serves the page, accepts connections within their limits, and
// moves whole messages between them and the ClientRegistry. One thread, one event loop that never
// blocks: unread messages stay in the client's outbox. An emergency stop has its own connection, so
// that no telemetry precedes it in any queue.

#include <functional>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "tools/lss-ground/access.h"

namespace lss::ground {

class ClientRegistry;

struct ServerOptions {
  Listen listen;
  std::string page;                  // folder; empty: none was built
  std::string certificate, key;      // of TLS; empty: none
  std::vector<std::string> origins;  // that may connect, in addition to the page's own
  std::vector<std::string>
      foxglove_origins;      // that may connect as Foxglove, in addition to all these
  std::size_t clients = 64;  // connections for looking and commanding; as many of Foxglove
  std::size_t stops = 64;    // reserved for stops: viewers cannot use them
};

class Server {
 public:
  static tl::expected<std::unique_ptr<Server>, std::string> create(const ServerOptions& options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // Until stop(). `news`: after wake(), soon; every tick: registry.tick(), then `tick`.
  void run(ClientRegistry& registry, const std::function<void()>& news,
           const std::function<void()>& tick);
  int port() const;

  // From any thread, also from a signal handler.
  void wake();
  void stop();

  struct Impl;

 private:
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace lss::ground
