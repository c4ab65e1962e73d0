// What a line of the IDL brings: the member is in records, in their JSON, in the columns of CSV and
// in the JSON of status, and no other list names it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lss_fields.h>  // of the IDL

#include <algorithm>
#include <cstring>

#include "daemon/record/compare.h"
#include "daemon/record/json.h"
#include "daemon/record/schema.h"
#include "daemon/replay/records.h"
#include "idl/idl_text.h"
#include "tools/lss-cli/recording/idl_types.h"
#include "tools/lss-cli/recording/record_layout.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/telemetry.h"

namespace lss::cli::recording {
namespace {

class FieldsOfTheIdl : public testing::TestWithParam<const Vehicle*> {
 protected:
  // Columns as lss-cli's own parser of IDL reads them.
  const Types types_{idl_text(GetParam()->name)};
  const Layout idl_{*types_.find(GetParam()->telemetry->m_typename)};
  const record::VehicleRecords records_ = *vehicle_records(std::string(GetParam()->name));
};

const char* schema_name(const Column& column) {
  if (column.text_size > 0) return "text";
  switch (column.type->kind) {
    case Kind::boolean: return "b1";
    case Kind::octet: return "u1";
    case Kind::character: return "c1";
    case Kind::int16: return "i2";
    case Kind::uint16: return "u2";
    case Kind::int32: return "i4";
    case Kind::uint32:
    case Kind::enumeration: return "u4";
    case Kind::int64: return "i8";
    case Kind::uint64: return "u8";
    case Kind::float32: return "f4";
    case Kind::float64: return "f8";
    case Kind::structure: break;
  }
  return "?";
}

TEST_P(FieldsOfTheIdl, AreTheColumnsOfRecords) {
  RecordLayout layout(records_.schema());
  layout.choose({"telemetry"});
  std::vector<std::pair<std::string, std::string>> wanted, got;
  for (const Column& column : idl_.columns()) {
    if (column.name != "vehicle_id")  // the key: the header of the file has it
      wanted.emplace_back("telemetry." + column.name, schema_name(column));
  }
  for (const RecordLayout::Column& column : layout.columns())
    got.emplace_back(column.name, column.type);
  EXPECT_GT(got.size(), 100u);
  EXPECT_EQ(got, wanted);
}

template <class Json>
void expect_all(const Layout& idl, const Json& telemetry) {
  for (const Column& column : idl.columns()) {
    if (column.name == "vehicle_id") continue;
    std::string path = "/" + column.name;  // modules[3].id: /modules/3/id
    std::erase(path, ']');
    for (const char sign : {'.', '['}) std::ranges::replace(path, sign, '/');
    EXPECT_TRUE(telemetry.contains(typename Json::json_pointer(path))) << path;
  }
  EXPECT_EQ(telemetry["state"], "Idle");
}

TEST_P(FieldsOfTheIdl, AreInTheJsonOfRecords) {
  const auto json = records_.to_json(std::vector<std::uint8_t>(1'000'000));
  expect_all(idl_, json.at("telemetry"));
}

TEST_P(FieldsOfTheIdl, AreInTheJsonOfStatus) {
  const std::vector<std::uint64_t> sample(GetParam()->telemetry->m_size / sizeof(std::uint64_t) +
                                          1);
  expect_all(idl_, status_json(*GetParam(), lss_Status{}, sample.data()).at("telemetry"));
  EXPECT_EQ(status_json(*GetParam(), lss_Status{}, nullptr).at("telemetry"), nullptr);
}

TEST(JsonOfTelemetry, HasNullForTheAgeOfWhatWasNeverHeard) {
  EXPECT_EQ(with_null_for_never({{"age_ms", 5}, {"parts", {{{"age_ms", kNeverHeard_ms}}, {}}}}),
            nlohmann::json({{"age_ms", 5}, {"parts", {{{"age_ms", nullptr}}, {}}}}));
}

INSTANTIATE_TEST_SUITE_P(Vehicles, FieldsOfTheIdl, testing::ValuesIn(vehicles()),
                         [](const auto& which) { return std::string(which.param->name); });

// Enumerations, texts and arrays as idlc makes them.
TEST(StructsOfTheIdl, AreWrittenComparedAndReadBack) {
  auto status = std::make_unique<lss_Status>();
  status->state = lss_STATE_FATAL_ERROR;
  std::strcpy(status->mode_name, "walking");
  std::strcpy(status->threads[1].name, "frame");
  status->threads[1].granted = true;
  status->faults[15].count = 7;

  record::Schema schema;
  fields(schema, *status);
  EXPECT_THAT(schema.text(),
              testing::StartsWith("vehicle:[16]c1;version:[24]c1;instance:{boot:u8;"));
  EXPECT_THAT(schema.text(), testing::HasSubstr(";state:u4;mode:u1;mode_name:[16]c1;"));
  EXPECT_THAT(schema.text(), testing::HasSubstr(";faults:[16]{id:u2;subject:u2;count:u4;"));

  std::vector<std::uint8_t> bytes(sizeof(lss_Status));
  record::Writer writer(bytes);
  fields(writer, *status);
  ASSERT_TRUE(writer.fits());
  bytes.resize(writer.size());
  auto read = std::make_unique<lss_Status>();
  record::Reader reader(bytes);
  fields(reader, *read);
  EXPECT_TRUE(reader.good() && reader.at_end());
  const auto json = record::to_json(*read);
  EXPECT_EQ(json, record::to_json(*status));
  EXPECT_EQ(json["mode_name"], "walking");
  EXPECT_EQ(json["threads"][1]["name"], "frame");
  EXPECT_EQ(json["threads"][1]["granted"], true);
  EXPECT_EQ(json["faults"][15]["count"], 7);

  record::Compare same(bytes);
  fields(same, *read);
  EXPECT_FALSE(same.difference());
  std::strcpy(read->threads[1].name, "bus");
  record::Compare other(bytes);
  fields(other, *read);
  ASSERT_TRUE(other.difference());
  EXPECT_EQ(other.difference()->field, "threads[1].name");
  EXPECT_EQ(other.difference()->recorded, "\"frame\"");
  EXPECT_EQ(other.difference()->computed, "\"bus\"");
}

}  // namespace
}  // namespace lss::cli::recording
