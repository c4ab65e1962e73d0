#include "tools/lss-cli/session/telemetry_type.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "lss.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

using recording::Column;
using recording::Kind;
using Json = nlohmann::ordered_json;

constexpr std::size_t kKeySize = sizeof lss_Status::vehicle_id;
constexpr std::byte kHeader[] = {std::byte{0}, std::byte{1}, std::byte{0},
                                 std::byte{0}};  // CDR, little-endian

const recording::Type& find_type(const recording::Types& types, const std::string& name) {
  const recording::Type* type = types.find(name);
  if (type == nullptr || type->kind != Kind::structure)
    throw Failure(ExitCode::failed, "the IDL of its telemetry does not have " + name);
  return *type;
}

std::uint32_t op_of(Kind kind) {
  switch (kind) {
    case Kind::boolean: return DDS_OP_TYPE_BLN;
    case Kind::octet:
    case Kind::character: return DDS_OP_TYPE_1BY;
    case Kind::int16:
    case Kind::uint16: return DDS_OP_TYPE_2BY;
    case Kind::int64:
    case Kind::uint64:
    case Kind::float64: return DDS_OP_TYPE_8BY;
    default: return DDS_OP_TYPE_4BY;
  }
}

constexpr std::uint32_t kMember = DDS_OP_ADR;
constexpr std::uint32_t kText = std::uint32_t{DDS_OP_TYPE_ARR} | std::uint32_t{DDS_OP_SUBTYPE_1BY};

// Every number alone: nested structs are flat in CDR.
std::vector<std::uint32_t> ops_of(const recording::Layout& layout) {
  std::vector<std::uint32_t> ops;
  for (const Column& column : layout.columns()) {
    const bool text = column.text_size > 0;
    const std::uint32_t key = ops.empty() ? DDS_OP_FLAG_KEY | DDS_OP_FLAG_MU : 0;
    ops.push_back(kMember | key | (text ? kText : op_of(column.type->kind)));
    ops.push_back(static_cast<std::uint32_t>(column.offset));
    if (text) ops.push_back(static_cast<std::uint32_t>(column.text_size));
  }
  ops.push_back(DDS_OP_RTS);
  ops.push_back(std::uint32_t{DDS_OP_KOF} | 1);
  ops.push_back(0);
  return ops;
}

void check(const recording::Layout& layout) {
  const std::vector<Column>& columns = layout.columns();
  const bool good = columns.size() > 1 && columns[0].name == "vehicle_id" &&
                    columns[0].text_size == kKeySize && columns[1].name == "time_ns" &&
                    columns[1].type->kind == Kind::int64;
  if (!good)
    throw Failure(ExitCode::failed, layout.type().name +
                                        " does not begin with char vehicle_id[16] and long long "
                                        "time_ns, as every telemetry does");
}

}  // namespace

TelemetryType::TelemetryType(std::string idl, const std::string& name)
    : idl_(std::move(idl)),
      types_(idl_),
      layout_(find_type(types_, name)),
      ops_(ops_of(layout_)),
      key_{"vehicle_id", static_cast<std::uint32_t>(ops_.size() - 2), 0} {
  check(layout_);
  constexpr std::size_t kAlign = 8;
  descriptor_.reset(new dds_topic_descriptor_t{
      .m_size = static_cast<std::uint32_t>((layout_.size() + kAlign - 1) / kAlign * kAlign),
      .m_align = kAlign,
      .m_flagset = DDS_TOPIC_FIXED_KEY | DDS_TOPIC_FIXED_KEY_XCDR2,
      .m_nkeys = 1,
      .m_typename = layout_.type().name.c_str(),
      .m_keys = &key_,
      .m_nops = static_cast<std::uint32_t>(layout_.columns().size() + 2),
      .m_ops = ops_.data(),
      .m_meta = "",
      .type_information = {},
      .type_mapping = {},
      .restrict_data_representation = 0});
}

std::vector<std::byte> TelemetryType::message(const void* sample) const {
  std::vector<std::byte> all(std::size(kHeader) + layout_.size());
  std::ranges::copy(kHeader, all.begin());
  std::memcpy(all.data() + std::size(kHeader), sample, layout_.size());
  return all;
}

Json TelemetryType::json(const void* sample) const {
  Json all = layout_.json(message(sample));
  all.erase("vehicle_id");
  return all;
}

std::optional<double> TelemetryType::number(std::string_view name, const void* sample) const {
  const Column* column = layout_.find(name);
  if (column == nullptr || column->text_size > 0) return std::nullopt;
  const double value = layout_.number(*column, message(sample));
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace lss::cli
