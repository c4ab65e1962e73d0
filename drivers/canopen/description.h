#pragma once

// Device descriptions of CANopen nodes: EDS and DCF files (CiA 306), as far as a master needs them:
// device type, objects with their types and values, and, in a section of our own, which object
// carries which signal and in what unit. Start-up only: it allocates. Any text is read without
// failing; what is wrong is named in sentences, and only a description without errors may be used.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lss::canopen {

struct DescribedObject {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 0;  // 1, 2, 4; 0: no number of these sizes
  bool is_signed = false;
  bool readable = false, writable = false;
  bool mappable = false;                     // into a PDO
  std::optional<std::uint32_t> value{};      // ParameterValue: written into the node (DCF)
  std::optional<std::uint32_t> by_itself{};  // DefaultValue
  int line = 0;
};

// Section [LssSignals], a line each: NAME=0xINDEX:SUB, UNIT, the unit of one count.
struct DescribedSignal {
  std::string name;
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  double unit = 1;
  int line = 0;
};

struct Description {
  std::string product;
  std::vector<DescribedObject> objects;  // by index and sub-index, each once
  std::vector<DescribedSignal> signals;

  const DescribedObject* find(std::uint16_t index, std::uint8_t sub) const;
  const DescribedSignal* signal(std::string_view name) const;
};

// Limits of a file.
inline constexpr std::size_t kMostDescriptionBytes = 256 * 1024, kMostLine = 1024;
inline constexpr std::size_t kMostObjects = 4096, kMostSignals = 64, kMostSentences = 20;

struct ReadDescription {
  Description description;
  std::vector<std::string> errors;  // "line 12: sentence"
};
ReadDescription read_description(std::string_view text);

}  // namespace lss::canopen
