// Message recordings (MCAP) with the IDL and the types in them: each is read, and partly copied, or
// refused with a sentence.

#include "tests/fuzz/fuzz.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/show/failure.h"

namespace {

using namespace lss::cli::recording;
using Json = nlohmann::ordered_json;

void read(const std::string& path, const std::string& part) {
  const auto recording = open(path);
  recording->each({}, [&](const Message& message) {
    (void)recording->seconds(message.publish_ns);
    const Layout* layout = message.topic.layout;
    if (layout == nullptr) return;
    (void)layout->json(message.data).dump(-1, ' ', false, Json::error_handler_t::replace);
    for (const Column& column : layout->columns()) (void)layout->text(column, message.data);
  });
  ::unlink(part.c_str());
  const std::uint64_t copied = recording->copy({}, part);
  const auto again = open(part);
  lss::fuzz::must(again->span().messages == copied, "a copy has the messages that were copied");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const lss::fuzz::File file(".mcap"), part(".mcap");
  file.write({data, size});
  try {
    read(file.path(), part.path());
  } catch (const lss::cli::Failure& failure) {
    lss::fuzz::must(*failure.what() != '\0', "a refusal says why");
  }
  return 0;
}
