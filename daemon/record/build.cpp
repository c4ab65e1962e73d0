#include "daemon/record/build.h"

#include <elf.h>
#include <fmt/format.h>
#include <link.h>

#include <cstring>
#include <string>

namespace lss::record {
namespace {

// The GNU build ID in the notes of the program, the first object of the list; "" without one.
int find_build_id(dl_phdr_info* object, std::size_t, void* result) {
  constexpr std::size_t kWord = 4;
  auto& id = *static_cast<std::string*>(result);
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = object->dlpi_phdr[i];
    if (segment.p_type != PT_NOTE) continue;
    const auto* at = reinterpret_cast<const unsigned char*>(object->dlpi_addr + segment.p_vaddr);
    const auto* end = at + segment.p_memsz;
    while (at + sizeof(ElfW(Nhdr)) <= end) {
      ElfW(Nhdr) note;
      std::memcpy(&note, at, sizeof note);
      const auto padded = [](std::size_t n) { return (n + kWord - 1) / kWord * kWord; };
      const unsigned char* name = at + sizeof note;
      const unsigned char* value = name + padded(note.n_namesz);
      if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == 4 &&
          std::memcmp(name, "GNU", 4) == 0) {
        for (std::size_t j = 0; j < note.n_descsz; ++j) id += fmt::format("{:02x}", value[j]);
        return 1;
      }
      at = value + padded(note.n_descsz);
    }
  }
  return 1;
}

std::string build_id() {
  std::string id;
  ::dl_iterate_phdr(find_build_id, &id);
  return id;
}

}  // namespace

nlohmann::ordered_json this_build() {
  return {{"id", build_id()}, {"compiler", __VERSION__}, {"type", LSS_BUILD_TYPE}};
}

std::string program_version(const std::string& version) {
  return fmt::format("{}, build {}", version, build_id());
}

}  // namespace lss::record
