// lss-ground: vehicles in a browser. See docs/ground.md.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "idl/refusal.h"
#include "tools/lss-cli/session/enclave_watch.h"
#include "tools/lss-ground/client_registry.h"
#include "tools/lss-ground/server.h"

namespace {

using namespace lss::ground;

constexpr int kWrongUsage = 2;

struct Options {
  int domain = 0;
  std::string enclave;
  std::string listen = "127.0.0.1:8470";
  std::string key_file;
  std::uint32_t lease_ms = 2000;
  ServerOptions server;
};

[[noreturn]] void fail(const std::string& why, int code = 1) {
  fmt::print(stderr, "lss-ground: {}\n", why);
  std::exit(code);
}

// The installed page, or that of the build folder, beside the program.
std::string default_page() {
  std::error_code none;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path above = program.parent_path().parent_path();
  for (const char* folder : {"share/lssd/ground", "ground"}) {
    if (std::filesystem::exists(above / folder / "index.html", none)) return above / folder;
  }
  return "";
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--domain", options.domain, "DDS domain of the vehicles")
      ->envname("LSS_DOMAIN")
      ->check(CLI::Range(0, 230))
      ->capture_default_str();
  app.add_option("--enclave", options.enclave,
                 "folder with certificates and permissions of the role command, for DDS Security")
      ->envname("LSS_ENCLAVE");
  app.add_option("--listen", options.listen,
                 "address and port; other than this machine's own only with --key-file")
      ->capture_default_str();
  app.add_option("--key-file", options.key_file,
                 "who gets in: lines of look, stop or command, and a key");
  app.add_option("--tls-cert", options.server.certificate, "certificate, PEM");
  app.add_option("--tls-key", options.server.key, "its private key, PEM");
  app.add_option("--page", options.server.page, "folder of the page that was built");
  app.add_option("--origin", options.server.origins,
                 "page that may connect besides our own, of a proxy: https://ground.example");
  app.add_option("--foxglove-origin", options.server.foxglove_origins,
                 "of a Foxglove that may connect, to look only: https://app.foxglove.dev");
  app.add_option("--lease-ms", options.lease_ms,
                 "a vehicle stops safely this long after the last heartbeat of the page")
      ->check(CLI::Range(500, 60000))
      ->capture_default_str();
  app.add_option("--clients", options.server.clients,
                 "connections at a time; as many to stop by, and of Foxglove")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
}

Door open_door(const Options& options, const Listen& listen) {
  Door door;
  if (!options.key_file.empty()) {
    auto read = Door::read(options.key_file);
    if (!read) fail(read.error(), kWrongUsage);
    door = std::move(*read);
  }
  if (!listen.loopback() && !door.locked()) {
    fail(
        "without --key-file only this machine is listened to: anybody could command the vehicle. "
        "Make one:\n  (umask 077; echo command $(openssl rand -hex 16) > ground.keys)",
        kWrongUsage);
  }
  if (!listen.loopback() && options.server.certificate.empty()) {
    fmt::print(stderr,
               "lss-ground: warning: keys and commands travel readable for everybody on the way; "
               "give --tls-cert and --tls-key\n");
  }
  return door;
}

Server* running = nullptr;

void end(int) { running->stop(); }

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Vehicles in a browser: watch, command and stop. Use and access: docs/ground.md"};
  app.set_version_flag("--version", "lss-ground " LSS_VERSION);
  Options options;
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kWrongUsage;
  }
  const auto listen = parse_listen(options.listen);
  if (!listen) fail(listen.error(), kWrongUsage);
  if (options.server.certificate.empty() != options.server.key.empty())
    fail("--tls-cert and --tls-key belong together", kWrongUsage);
  if (!options.server.certificate.empty()) {
    const auto good = check_tls(options.server.certificate, options.server.key);
    if (!good) fail(good.error(), kWrongUsage);
  }
  options.server.listen = *listen;
  options.server.stops = options.server.clients;
  if (options.server.page.empty()) {
    options.server.page = default_page();
  } else if (std::error_code none;
             !std::filesystem::exists(options.server.page + "/index.html", none)) {
    fail(options.server.page + " has no index.html: name the folder of the page that was built",
         kWrongUsage);
  }
  const Door door = open_door(options, *listen);

  auto server = Server::create(options.server);
  if (!server) fail(server.error());
  auto fleet = Fleet::create(options.domain, options.enclave, [&] { (*server)->wake(); });
  if (!fleet) fail(fleet.error().text, fleet.error().cure == lss::Cure::change ? kWrongUsage : 1);
  lss::cli::EnclaveWatch enclave("lss-ground", (*fleet)->participant());
  ClientRegistry registry(**fleet, door, options.lease_ms);

  running = server->get();
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);
  const std::string host = listen->address.find(':') != std::string::npos
                               ? "[" + listen->address + "]"
                           : listen->address.empty() ? "0.0.0.0"
                                                     : listen->address;
  fmt::print("http{}://{}:{}/\n", options.server.certificate.empty() ? "" : "s", host,
             (*server)->port());
  std::fflush(stdout);
  (*server)->run(
      registry, [&] { (*fleet)->take(); }, [&] { enclave.look(); });
  return 0;
}
