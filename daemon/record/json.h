#pragma once

// Records as JSON, for people: names for numbered things, characters as text, null for NaN.
// Ordinary threads.

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/record/fields.h"

namespace lss::record {

template <class T>
nlohmann::ordered_json to_json(const T& x);
template <Array T>
nlohmann::ordered_json to_json(const T& list);
template <Text T>
nlohmann::ordered_json to_json(const T& text);
template <class... T>
nlohmann::ordered_json to_json(const std::variant<T...>& x);

inline nlohmann::ordered_json name_of(const CodeInfo* info, std::uint16_t number) {
  return info != nullptr ? nlohmann::ordered_json(info->name) : nlohmann::ordered_json(number);
}

// Faults are events, too.
inline nlohmann::ordered_json event_name(std::uint16_t id, const OwnCodes& own = own_codes) {
  return name_of(event_info(id, own), id);
}

// The struct of a telemetry topic: its IDL has the state as a number.
template <class T>
concept TelemetrySample = requires(const T& x) {
  x.vehicle_id, x.state;
};

class JsonWriter {
 public:
  template <class T>
  void operator()(const char* name, const T& x) {
    json_[name] = to_json(x);
  }
  template <class T, std::size_t N>
  void list(const char* name, const std::array<T, N>& x, const std::uint32_t& count) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (std::uint32_t i = 0; i < count; ++i) list.push_back(to_json(x[i]));
    json_[name] = std::move(list);
  }
  nlohmann::ordered_json take() { return std::move(json_); }

 private:
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
};

template <Array T>
nlohmann::ordered_json to_json(const T& list) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const auto& x : list) json.push_back(to_json(x));
  return json;
}
template <Text T>
nlohmann::ordered_json to_json(const T& text) {
  return std::string(std::data(text), ::strnlen(std::data(text), std::size(text)));
}

template <class... T>
nlohmann::ordered_json to_json(const std::variant<T...>& x) {
  return std::visit([](const auto& alternative) { return to_json(alternative); }, x);
}

template <class T>
nlohmann::ordered_json to_json(const T& x) {
  if constexpr (std::same_as<T, State>) {
    return kStateNames[static_cast<std::size_t>(x) & 3];
  } else if constexpr (std::same_as<T, Reason> || std::same_as<T, FaultId>) {
    return name_of(info(x), static_cast<std::uint16_t>(x));
  } else if constexpr (std::is_enum_v<T>) {
    return static_cast<std::int64_t>(x);
  } else if constexpr (std::is_arithmetic_v<T>) {
    return x;
  } else {
    JsonWriter writer;
    record::visit(writer, x);
    nlohmann::ordered_json json = writer.take();
    if constexpr (std::same_as<T, EventRecord>) json["name"] = event_name(x.id);
    if constexpr (TelemetrySample<T>) json["state"] = to_json(static_cast<State>(x.state));
    return json;
  }
}

}  // namespace lss::record
