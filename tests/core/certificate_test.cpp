// Timing certificates: what they are valid for, and which frame exceeds one.

#include "daemon/record/certificate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "daemon/cycle/text.h"
#include "tests/support/temp_folder.h"

namespace lss::record {
namespace {

using testing::HasSubstr;

constexpr TimeNs kPeriod = 20 * kMillisecond, kOffset = 5 * kMillisecond;
const Certificate kAllowed{
    .on = {}, .ready_ns = 400 * kMicrosecond, .release_ns = 100 * kMicrosecond};

// A frame that was ready and whose predecessor was released after these times.
TimingPoints frame(std::uint64_t number, TimeNs ready_ns, TimeNs release_ns) {
  const TimeNs boundary_ns = static_cast<TimeNs>(number) * kPeriod;
  return {.frame = number,
          .boundary_ns = boundary_ns,
          .ready_ns = boundary_ns + ready_ns,
          .released_ns = boundary_ns - kPeriod + kOffset + release_ns,
          .offset_ns = kOffset};
}

struct Watched {
  CertificateWatch watch{kAllowed};
  std::vector<EventRecord> events;
  void look(const TimingPoints& t) {
    watch.look(t, [&](const EventRecord& event) { events.push_back(event); });
  }
  std::string text(std::size_t i) const { return event_text(events.at(i), {}, {}); }
};

TEST(CertificateWatch, SaysNothingOfFramesWithinTheBoundsAndAtThem) {
  Watched w;
  for (std::uint64_t i = 1; i < 100; ++i) w.look(frame(i, 399 * kMicrosecond, 99 * kMicrosecond));
  w.look(frame(100, kAllowed.ready_ns, kAllowed.release_ns));
  EXPECT_TRUE(w.events.empty());
}

TEST(CertificateWatch, ReportsTheFrameThatIsLateWithWhatWasMeasuredAndAllowed) {
  Watched w;
  w.look(frame(7, 10 * kMicrosecond, 0));
  w.look(frame(8, 400 * kMicrosecond + 500, 0));
  w.look(frame(9, 10 * kMicrosecond, 0));
  ASSERT_EQ(w.events.size(), 1u);
  EXPECT_EQ(w.events[0].id, static_cast<std::uint16_t>(EventId::ready_uncertified));
  EXPECT_EQ(w.events[0].time_ns, 8 * kPeriod + 400 * kMicrosecond + 500);
  EXPECT_EQ(w.text(0),
            "frame 8: its command was ready 400.5 us after the boundary, certified are "
            "400");
}

TEST(CertificateWatch, ReportsALateReleaseWithItsFrame) {
  Watched w;
  w.look(frame(7, 0, 0));
  w.look(frame(8, 0, 250 * kMicrosecond));
  ASSERT_EQ(w.events.size(), 1u);
  EXPECT_EQ(w.events[0].id, static_cast<std::uint16_t>(EventId::release_uncertified));
  EXPECT_EQ(w.text(0), "frame 7: its command was released 250 us late, certified are 100");
}

TEST(CertificateWatch, KnowsNoReleaseOfAFrameThatIsMissing) {
  Watched w;
  w.look(frame(7, 0, kPeriod));  // no frame before it is known
  w.look(frame(9, 0, kPeriod));
  EXPECT_TRUE(w.events.empty());
  w.look(frame(10, 0, kPeriod));
  EXPECT_EQ(w.events.size(), 1u);
}

TEST(Certificate, IsForTheValuesOfAConfigurationAndNotForItsText) {
  const auto of = [](const char* text) { return certified_here("1", text).configuration; };
  const std::string one = of("vehicle = 'zebro'\n[frame]\nperiod_ms = 20\noffset_ms = 5\n");
  EXPECT_EQ(one.size(), 8u);
  EXPECT_EQ(of("# other words\nvehicle = \"zebro\"\nframe = {offset_ms = 5, period_ms = 20}\n"),
            one);
  EXPECT_EQ(of("vehicle = 'zebro'\n[frame]\nperiod_ms = 20\noffset_ms = 5\n"
               "[timing]\ncertificate = '/a'\n"),
            one);
  EXPECT_NE(of("vehicle = 'zebro'\n[frame]\nperiod_ms = 20\noffset_ms = 6\n"), one);
}

TEST(Certificate, OfAnotherMachineKernelVersionOrConfigurationIsNotValid) {
  const CertifiedOn here = certified_here("0.1.0, build 77", "a = 1");
  EXPECT_FALSE(here.machine.empty());
  EXPECT_THAT(here.kernel, HasSubstr("Linux "));
  EXPECT_EQ(not_valid(here, here), "");
  const auto why = [&](std::string CertifiedOn::*what) {
    CertifiedOn made = here;
    made.*what = "of\nold";
    return not_valid(made, here);
  };
  EXPECT_EQ(why(&CertifiedOn::machine),
            "the machine was \"of old\" and is \"" + here.machine + "\"");
  EXPECT_THAT(why(&CertifiedOn::kernel), HasSubstr("the kernel was"));
  EXPECT_EQ(why(&CertifiedOn::version),
            "the version of lssd was \"of old\" and is \"0.1.0, build 77\"");
  EXPECT_THAT(why(&CertifiedOn::configuration), HasSubstr("the configuration was"));
}

class CertificateFile : public testing::Test {
 protected:
  auto read(const std::string& text) {
    testing_support::put_content(path_, text);
    return read_certificate(path_);
  }
  std::string error(const std::string& text) {
    const auto certificate = read(text);
    return certificate ? "" : certificate.error();
  }
  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "certificate.json").string();
};

constexpr const char* kOn =
    R"({"machine": "m", "kernel": "k", "version": "v", "configuration": "c")";

TEST_F(CertificateFile, IsRead) {
  const auto c = read(std::string(kOn) + R"(, "ready": {"us": 412.5}, "release": {"us": 99}})");
  ASSERT_TRUE(c) << c.error();
  EXPECT_EQ(c->on.kernel, "k");
  EXPECT_EQ(c->ready_ns, 412'500);
  EXPECT_EQ(c->release_ns, 99'000);
}

TEST_F(CertificateFile, ThatIsNoneIsRefusedWithItsName) {
  EXPECT_THAT(error(""), HasSubstr(path_ + ": no timing certificate"));
  EXPECT_THAT(error("[1, 2]"), HasSubstr("no timing certificate"));
  EXPECT_THAT(error(R"({"machine": 7})"), HasSubstr("no timing certificate"));
  EXPECT_THAT(error(std::string(200'000, '[')), HasSubstr("no timing certificate"));
  for (const char* us : {"0", "-1", "1e9", "null", "\"12\"", "{}"}) {
    const std::string text = std::string(kOn) + R"(, "release": {"us": 5}, "ready": {"us": )" + us;
    EXPECT_THAT(error(text + "}}"), HasSubstr("ready.us")) << us;
  }
  EXPECT_THAT(error(std::string(kOn) + "}"), HasSubstr("ready.us"));
  EXPECT_THAT(read_certificate(folder_ / "none").error(), HasSubstr("there is no such file"));
  EXPECT_THAT(read_certificate(folder_).error(), HasSubstr("there is no such file"));
}

}  // namespace
}  // namespace lss::record
