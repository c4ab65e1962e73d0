// Flight recordings as lss-cli reads them, with right checksums and without: each is read or
// refused with a sentence.

#include "tests/fuzz/sealed.h"
#include "tools/lss-cli/recording/flight.h"
#include "tools/lss-cli/show/failure.h"

namespace {

using namespace lss::cli::recording;
using Json = nlohmann::ordered_json;

void read(const std::string& path) {
  Flight flight(path);
  (void)flight.complaint();
  (void)flight.duration_s();
  std::vector<Json> values;
  flight.each({.damaged = true}, [&](const Flight::Frame& frame) {
    (void)flight.layout().json(frame.record).dump(-1, ' ', false, Json::error_handler_t::replace);
    flight.layout().look(frame.record);
  });
  flight.layout().choose_what_is_always_there();
  const auto columns = flight.layout().columns();
  flight.each({.damaged = true}, [&](const Flight::Frame& frame) {
    flight.layout().values(frame.record, values);
    lss::fuzz::must(values.size() == columns.size(), "each column has a value");
  });
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const lss::fuzz::File file(".lssrec");
  lss::fuzz::Input in({data, size});
  const bool sealed = in.below(8) != 0;
  const lss::fuzz::Bytes bytes = in.rest();
  if (sealed) {
    file.write(lss::fuzz::sealed_recording(bytes));
  } else {
    file.write(bytes);
  }
  try {
    read(file.path());
  } catch (const lss::cli::Failure& failure) {
    lss::fuzz::must(*failure.what() != '\0', "a refusal says why");
  }
  return 0;
}
