#include "tools/lss-cli/doctor/read_config.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include "daemon/config/document.h"

namespace lss::cli::doctor {
namespace {

// Calls read(table) for each of [[name]].
template <class Read>
void for_each_table(toml::node_view<const toml::node> list, Read read) {
  if (const toml::array* array = list.as_array()) {
    for (const toml::node& element : *array) {
      if (const toml::table* table = element.as_table()) read(*table);
    }
  }
}

config::Config from(const toml::table& root, const std::filesystem::path& file) {
  config::Config config;
  config.file = file.string();
  config.vehicle = root["vehicle"].value_or("");
  config.vehicle_id = root["vehicle_id"].value_or(config.vehicle + "-1");
  for_each_table(root["port"], [&](const toml::table& port) {
    config.ports.push_back({.name = port["name"].value_or(""), .path = port["path"].value_or("")});
  });
  config.realtime_enforce = root["realtime"]["policy"].value_or("") == std::string_view("enforce");
  for_each_table(root["realtime"]["thread"], [&](const toml::table& table) {
    config::Thread thread;
    thread.name = table["name"].value_or("");
    thread.priority = table["priority"].value_or(thread.priority);
    thread.cpu = table["cpu"].value_or(thread.cpu);
    config.threads.push_back(thread);
  });
  const auto dds = root["dds"];
  config.domain = dds["domain"].value_or(config.domain);
  config.shared_memory = dds["shared_memory"].value_or(config.shared_memory);
  if (const toml::array* interfaces = dds["interfaces"].as_array()) {
    config.interfaces.clear();
    for (const toml::node& name : *interfaces)
      config.interfaces.push_back(name.value_or(std::string()));
  }
  return config;
}

}  // namespace

tl::expected<config::Config, std::string> read_config(const std::filesystem::path& file) {
  const auto text = config::read_document(file);
  if (!text) return tl::unexpected(fmt::format("{}: {}", file.string(), text.error()));
  try {
    return from(toml::parse(*text, file.string()), file);
  } catch (const toml::parse_error& fault) {
    const toml::source_position at =
        fault.source().begin ? fault.source().begin : toml::source_position{1, 1};
    return tl::unexpected(fmt::format("{}:{}:{}: not TOML: {}", file.string(), at.line, at.column,
                                      config::one_line(std::string(fault.description()))));
  }
}

std::vector<std::filesystem::path> configurations(const System& system) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : names_in(system.configurations)) {
    // RouDi's configuration is in the same folder and has another format.
    if (name.ends_with(".toml") && name != "roudi.toml")
      files.push_back(system.configurations / name);
  }
  return files;
}

}  // namespace lss::cli::doctor
