// Daemons that name one another to clients.

#include "idl/other_daemons.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/dds/dds_support.h"
#include "tests/support/eventually.h"

namespace lss::dds {
namespace {

using testing_support::eventually;

Participant participant(bool daemon) {
  return testing_support::value(Participant::create(
      {.domain = testing_support::test_domain(), .interfaces = {"lo"}, .daemon = daemon}));
}

std::optional<unsigned> known_by(const std::string& user_data) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, user_data.data(), user_data.size());
  const std::optional<unsigned> others = others_known(qos);
  dds_delete_qos(qos);
  return others;
}

TEST(OtherDaemons, AreReadFromUserData) {
  EXPECT_EQ(known_by("lssd"), 0u);
  EXPECT_EQ(known_by("lssd 12"), 12u);
  EXPECT_EQ(known_by("lssd 4294967295"), kMostOthers) << "of an attacker";
  for (const char* other : {"", "lss", "lssd ", "lssd2", "lssd -1", "lssd 1x", "lssd 99999999999",
                            "enclave=/;", " lssd"})
    EXPECT_EQ(known_by(other), std::nullopt) << other;
}

TEST(OtherDaemons, AreCountedWithoutClientsAndForgottenWhenTheyEnd) {
  const Participant domain = participant(false), first = participant(true);
  OtherDaemons others(first);
  const auto are = [&](unsigned count) {
    return eventually([&] {
      others.look();
      return others.count() == count;
    });
  };
  {
    const Participant second = participant(true), third = participant(true);
    EXPECT_TRUE(are(2));
  }
  EXPECT_TRUE(are(0));
}

TEST(OtherDaemons, AreReportedToAClientThatComesLater) {
  const Participant domain = participant(false), first = participant(true);
  auto second = std::make_unique<Participant>(participant(true));
  OtherDaemons others(first);
  ASSERT_TRUE(eventually([&] {
    others.look();
    return others.count() == 1;
  }));
  // Another process would see the same user data; a reader of this one sees all participants.
  const Entity reader(
      dds_create_reader(domain.get(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  std::optional<unsigned> most;
  EXPECT_TRUE(eventually([&] {
    take_participants(
        reader.get(),
        [&](const Guid&, const std::optional<unsigned>& known) { most = std::max(most, known); },
        [](const Guid&) {});
    return most == 1u;
  }));
}

}  // namespace
}  // namespace lss::dds
