#include "tools/lss-ground/server.h"

#include <fmt/format.h>
#include <libwebsockets.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <new>

#include "tools/lss-ground/client_registry.h"

namespace lss::ground {
namespace {

constexpr const char* kDataProtocol = "lss-ground";
constexpr const char* kStopProtocol = "lss-stop";
// Two names of one protocol; newer versions of Foxglove ask for the second.
constexpr const char *kFoxglove = "foxglove.websocket.v1", *kFoxgloveSdk = "foxglove.sdk.v1";
constexpr std::size_t kReceive = 4096;    // a longer message comes in pieces
constexpr std::size_t kSend = 64 * 1024;  // handed to the kernel at a time
constexpr int kKernelBuffer = 64 * 1024;
constexpr std::size_t kHttpConnections = 64;  // additional: browsers load the page over several
constexpr unsigned kHandshake_s = 5;          // for the complete request of a connection
constexpr unsigned kPing_s = 5, kHangUp_s = 10;

static_assert(LWS_PRE <= 32, "Frame leaves too little room");

// Stored in memory of libwebsockets, which is initially zero.
struct Connection {
  Client* client;
  std::string* message;  // the parts received so far
};

std::string header(lws* wsi, lws_token_indexes which) {
  std::array<char, 512> text{};
  const int size = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), which);
  // A value that is too long counts as present and wrong.
  if (size < 0 && lws_hdr_total_length(wsi, which) > 0) return "?";
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "";
}

// Of the address; empty: there is none.
std::string argument(lws* wsi, const char* name) {
  std::array<char, 512> text{};
  const char* value = lws_get_urlarg_by_name(wsi, name, text.data(), static_cast<int>(text.size()));
  return value != nullptr ? value : "";
}

Client::Line line_of(const lws_protocols* protocol) {
  const std::string_view name = protocol != nullptr ? protocol->name : "";
  if (name == kStopProtocol) return Client::Line::stop;
  return name == kFoxglove || name == kFoxgloveSdk ? Client::Line::foxglove : Client::Line::data;
}

// As whom we run; int or unsigned, as the version of libwebsockets has it.
void keep_user(lws_context_creation_info& info) {
  info.gid = static_cast<decltype(info.gid)>(-1);
  info.uid = static_cast<decltype(info.uid)>(-1);
}

}  // namespace

struct Server::Impl {
  ServerOptions options;
  lws_context* context = nullptr;
  lws_vhost* vhost = nullptr;
  ClientRegistry* registry = nullptr;
  std::function<void()> news, after_tick;
  std::atomic<bool> ending{false}, woken{false};
  std::size_t sockets = 0;
  struct Timer {
    lws_sorted_usec_list_t list{};
    Impl* impl = nullptr;
  } timer;

  lws_http_mount mount{};
  lws_retry_bo_t keep_alive{};
  std::array<lws_protocols, 6> protocols{};

  int on_http(lws* wsi, lws_callback_reasons reason, void* user, void* in, std::size_t size);
  int on_socket(lws* wsi, lws_callback_reasons reason, Connection& connection, const char* in,
                std::size_t size);
  bool may_enter(lws* wsi, Client::Line line) const;
  int receive(lws* wsi, Connection& connection, std::string_view piece);
  int send(lws* wsi, Connection& connection);
  void tick();

  static Impl& of(lws* wsi) { return *static_cast<Impl*>(lws_context_user(lws_get_context(wsi))); }
  static int http(lws* wsi, lws_callback_reasons reason, void* user, void* in, std::size_t size) {
    return of(wsi).on_http(wsi, reason, user, in, size);
  }
  static int socket(lws* wsi, lws_callback_reasons reason, void* user, void* in, std::size_t size) {
    // Some callbacks come before the connection has its memory.
    static Connection none;
    Connection& connection = user != nullptr ? *static_cast<Connection*>(user) : none;
    return of(wsi).on_socket(wsi, reason, connection, static_cast<const char*>(in), size);
  }
};

int Server::Impl::on_http(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                          std::size_t size) {
  switch (reason) {
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
      if (registry != nullptr &&
          sockets >= 2 * options.clients + options.stops + kHttpConnections) {
        registry->refused();
        return 1;
      }
      return 0;
    case LWS_CALLBACK_WSI_CREATE: ++sockets; return 0;
    case LWS_CALLBACK_WSI_DESTROY: --sockets; return 0;
    case LWS_CALLBACK_HTTP: {
      // Files that the mount does not contain.
      if (options.page.empty()) {
        lws_return_http_status(wsi, HTTP_STATUS_SERVICE_UNAVAILABLE,
                               "The page was not built: cmake --build --preset release --target "
                               "lss-ground-page");
      } else {
        lws_return_http_status(wsi, HTTP_STATUS_NOT_FOUND, nullptr);
      }
      return -1;
    }
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
      if (woken.exchange(false) && news) news();
      return 0;
    default: return lws_callback_http_dummy(wsi, reason, user, in, size);
  }
}

bool Server::Impl::may_enter(lws* wsi, Client::Line line) const {
  const std::string origin = header(wsi, WSI_TOKEN_ORIGIN);
  const std::string host = header(wsi, WSI_TOKEN_HOST);
  const bool tls = !options.certificate.empty();
  const auto& more = line == Client::Line::foxglove ? options.foxglove_origins : options.origins;
  if (!good_origin(origin, host, options.listen.loopback(), tls, more)) return false;
  const std::size_t most = line == Client::Line::stop ? options.stops : options.clients;
  return registry->clients(line) < most;
}

int Server::Impl::on_socket(lws* wsi, lws_callback_reasons reason, Connection& connection,
                            const char* in, std::size_t size) {
  const Client::Line line = line_of(lws_get_protocol(wsi));
  switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
      if (registry == nullptr || !may_enter(wsi, line)) {
        if (registry != nullptr) registry->refused();
        return 1;
      }
      if (line == Client::Line::foxglove && !registry->may_look(argument(wsi, "key="))) return 1;
      return 0;
    case LWS_CALLBACK_ESTABLISHED: {
      // Data in the kernel's buffer would be sent late: the outbox keeps only the newest instead.
      const int buffer = kKernelBuffer;
      setsockopt(lws_get_socket_fd(wsi), SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
      connection.message = new std::string;
      connection.client = &registry->enter(
          line, [wsi] { lws_callback_on_writable(wsi); },
          [wsi] { lws_set_timeout(wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC); });
      if (line == Client::Line::foxglove)
        registry->show(*connection.client, argument(wsi, "vehicle="));
      return 0;
    }
    case LWS_CALLBACK_CLOSED:
      if (connection.client != nullptr && registry != nullptr) registry->leave(*connection.client);
      delete connection.message;
      connection = {};
      return 0;
    case LWS_CALLBACK_RECEIVE: return receive(wsi, connection, {in, size});
    case LWS_CALLBACK_SERVER_WRITEABLE: return send(wsi, connection);
    default: return 0;
  }
}

int Server::Impl::receive(lws* wsi, Connection& connection, std::string_view piece) {
  Client& client = *connection.client;
  const std::size_t longest = client.role == Role::none ? kMaxHello : kMaxMessage;
  if (lws_frame_is_binary(wsi) || connection.message->size() + piece.size() > longest) {
    registry->too_long(client);
  } else {
    connection.message->append(piece);
    if (lws_is_final_fragment(wsi) && lws_remaining_packet_payload(wsi) == 0) {
      registry->receive(client, *connection.message);
      connection.message->clear();
    }
  }
  if (client.doomed) lws_callback_on_writable(wsi);
  return 0;
}

int Server::Impl::send(lws* wsi, Connection& connection) {
  Client& client = *connection.client;
  if (client.doomed) {
    std::string why = client.why;
    lws_close_reason(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION,
                     reinterpret_cast<unsigned char*>(why.data()), why.size());
    return -1;
  }
  if (client.outbox.empty()) return 0;
  const FramePtr frame = client.outbox.pop(Clock::now());
  const lws_write_protocol how = frame->binary() ? LWS_WRITE_BINARY : LWS_WRITE_TEXT;
  if (lws_write(wsi, frame->text(), frame->size(), how) < 0) return -1;
  if (!client.outbox.empty()) lws_callback_on_writable(wsi);
  return 0;
}

void Server::Impl::tick() {
  registry->tick();
  for (Client* client : registry->doomed()) client->hang_up();
  after_tick();
  lws_sul_schedule(
      context, 0, &timer.list,
      [](lws_sorted_usec_list_t* list) { lws_container_of(list, Timer, list)->impl->tick(); },
      std::chrono::duration_cast<std::chrono::microseconds>(kTick).count());
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  impl_->registry = nullptr;
  if (impl_->context != nullptr) lws_context_destroy(impl_->context);
}

tl::expected<std::unique_ptr<Server>, std::string> Server::create(const ServerOptions& options) {
  lws_set_log_level(LLL_ERR, nullptr);
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->options.foxglove_origins.insert(impl->options.foxglove_origins.end(),
                                        options.origins.begin(), options.origins.end());
  impl->timer.impl = impl.get();

  lws_protocols& http = impl->protocols[0];
  http.name = "http";
  http.callback = Impl::http;
  std::size_t next = 1;
  for (const char* name : {kDataProtocol, kStopProtocol, kFoxglove, kFoxgloveSdk}) {
    lws_protocols& protocol = impl->protocols[next++];
    protocol.name = name;
    protocol.callback = Impl::socket;
    protocol.per_session_data_size = sizeof(Connection);
    protocol.rx_buffer_size = kReceive;
    protocol.tx_packet_size = kSend;
  }
  impl->mount.mountpoint = "/";
  impl->mount.mountpoint_len = 1;
  impl->mount.origin = impl->options.page.c_str();
  impl->mount.origin_protocol = LWSMPRO_FILE;
  impl->mount.def = "index.html";

  // Closes a connection whose other end has gone.
  lws_retry_bo_t& keep_alive = impl->keep_alive;
  keep_alive.secs_since_valid_ping = kPing_s;
  keep_alive.secs_since_valid_hangup = kHangUp_s;
  lws_context_creation_info info{};
  info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS;
  info.user = impl.get();
  info.timeout_secs = kHandshake_s;  // of libwebsockets 4.3; that of the vhost is of 4.1
  keep_user(info);
  impl->context = lws_create_context(&info);
  if (impl->context == nullptr)
    return tl::unexpected(std::string("the server cannot be made: out of memory?"));

  const Listen& listen = impl->options.listen;
  lws_context_creation_info vhost{};
  vhost.options = LWS_SERVER_OPTION_HTTP_HEADERS_SECURITY_BEST_PRACTICES_ENFORCE |
                  LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
  if (listen.address.find(':') == std::string::npos)
    vhost.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
  vhost.iface = listen.address.empty() ? nullptr : listen.address.c_str();
  vhost.port = listen.port;
  vhost.protocols = impl->protocols.data();
  vhost.mounts = impl->options.page.empty() ? nullptr : &impl->mount;
  vhost.vhost_name = "lss-ground";
  vhost.server_string = "lss-ground";
  vhost.timeout_secs = vhost.timeout_secs_ah_idle = kHandshake_s;
  vhost.retry_and_idle_policy = &impl->keep_alive;
  keep_user(vhost);
  if (!options.certificate.empty()) {
    vhost.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
    vhost.ssl_cert_filepath = impl->options.certificate.c_str();
    vhost.ssl_private_key_filepath = impl->options.key.c_str();
    vhost.alpn = "http/1.1";
  }
  impl->vhost = lws_create_vhost(impl->context, &vhost);
  if (impl->vhost == nullptr) {
    lws_context_destroy(impl->context);
    return tl::unexpected(fmt::format(
        "cannot listen on {}:{}: is the port taken, and the address one of this machine?",
        listen.address, listen.port));
  }
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

int Server::port() const { return lws_get_vhost_listen_port(impl_->vhost); }

void Server::run(ClientRegistry& registry, const std::function<void()>& news,
                 const std::function<void()>& tick) {
  impl_->registry = &registry;
  impl_->news = news;
  impl_->after_tick = tick;
  impl_->tick();
  news();
  while (!impl_->ending && lws_service(impl_->context, 0) >= 0) {
  }
}

void Server::wake() {
  impl_->woken = true;
  lws_cancel_service(impl_->context);
}

void Server::stop() {
  impl_->ending = true;
  lws_cancel_service(impl_->context);
}

}  // namespace lss::ground
