#include "tools/lss-sim/canopen/objects.h"

#include <algorithm>

namespace lss::sim::nodes {

std::int64_t to_signed(std::uint32_t value, std::size_t bytes) {
  if (bytes == 1) return static_cast<std::int8_t>(value);
  if (bytes == 2) return static_cast<std::int16_t>(value);
  return static_cast<std::int32_t>(value);
}

void Objects::add(std::span<const Object> objects) {
  for (const Object& object : objects) add(object);
}

void Objects::reset() {
  for (Entry& each : entries_) each.value = static_cast<std::uint32_t>(each.object.initial);
}

Objects::Entry* Objects::entry(std::uint16_t index, std::uint8_t sub) {
  const auto found = std::ranges::find_if(entries_, [&](const Entry& each) {
    return each.object.index == index && each.object.sub == sub;
  });
  return found == entries_.end() ? nullptr : &*found;
}

const Objects::Entry* Objects::entry(std::uint16_t index, std::uint8_t sub) const {
  return const_cast<Objects*>(this)->entry(index, sub);
}

const Object* Objects::find(std::uint16_t index, std::uint8_t sub) const {
  const Entry* found = entry(index, sub);
  return found != nullptr ? &found->object : nullptr;
}

bool Objects::has_index(std::uint16_t index) const {
  return std::ranges::any_of(entries_,
                             [&](const Entry& each) { return each.object.index == index; });
}

std::uint32_t Objects::get(std::uint16_t index, std::uint8_t sub) const {
  const Entry* found = entry(index, sub);
  return found != nullptr ? found->value : 0;
}

std::int64_t Objects::get_signed(std::uint16_t index, std::uint8_t sub) const {
  const Entry* found = entry(index, sub);
  return found != nullptr ? to_signed(found->value, found->object.bytes) : 0;
}

void Objects::set(std::uint16_t index, std::uint8_t sub, std::int64_t value) {
  Entry* found = entry(index, sub);
  if (found == nullptr) return;
  const unsigned bits = 8u * found->object.bytes;
  const std::uint32_t mask = bits == 32 ? ~0u : (1u << bits) - 1;
  found->value = static_cast<std::uint32_t>(value) & mask;
}

Abort Objects::check(std::uint16_t index, std::uint8_t sub, std::size_t bytes,
                     std::uint32_t value) const {
  const Object* object = find(index, sub);
  if (object == nullptr) return has_index(index) ? kNoSubIndex : kNoObject;
  if (object->access == Access::read_only) return kReadOnly;
  if (bytes != object->bytes) return kWrongLength;
  if (object->min == 0 && object->max == 0) return kDone;
  const std::int64_t number =
      object->is_signed ? to_signed(value, bytes) : static_cast<std::int64_t>(value);
  return number < object->min || number > object->max ? kOutOfRange : kDone;
}

}  // namespace lss::sim::nodes
