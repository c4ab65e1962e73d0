// The IDL in a recording or a dictionary: the name of a type, a line end, and the text.

#include "tests/fuzz/fuzz.h"
#include "tools/lss-cli/recording/idl_types.h"
#include "tools/lss-cli/show/failure.h"

namespace {

using namespace lss::cli::recording;

void read(std::string_view name, std::string_view idl) {
  const Types types(idl);
  const Type* type = types.find(name);
  if (type == nullptr || type->kind != Kind::structure) return;
  const Layout layout(*type);
  std::string message("\0\1\0\0", 4);
  message.resize(4 + layout.size(), '\1');
  layout.check(bytes_of(message));
  const auto json = layout.json(bytes_of(message));
  lss::fuzz::must(json.is_object(), "a struct is an object");
  std::size_t end = 0;
  for (const Column& column : layout.columns()) {
    lss::fuzz::must(column.offset >= end && column.offset < layout.size(), "columns are in order");
    end = column.offset;
    lss::fuzz::must(layout.find(column.name) != nullptr, "a column is found by its name");
    (void)layout.number(column, bytes_of(message));
    (void)layout.text(column, bytes_of(message));
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const std::size_t line = std::min(all.find('\n'), size);
  try {
    read(all.substr(0, line), all.substr(std::min(line + 1, size)));
  } catch (const lss::cli::Failure& failure) {
    lss::fuzz::must(*failure.what() != '\0', "a refusal says why");
  }
  return 0;
}
