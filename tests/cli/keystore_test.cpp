// Keystores, checked by the program openssl.

#include "tools/lss-cli/keystore/keystore.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <functional>

#include "idl/security.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::AllOf;
using testing::HasSubstr;

bool openssl(const std::string& words) {
  return std::system(("openssl " + words + " >/dev/null 2>&1").c_str()) == 0;
}

mode_t mode_of(const fs::path& path) {
  struct stat about {};
  EXPECT_EQ(::stat(path.c_str(), &about), 0) << path;
  return about.st_mode & 0777;
}

template <class Call>
std::string failure_of(Call call) {
  try {
    call();
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "";
}

class Keystore : public testing::Test {
 protected:
  Keystore() { create_keystore(store_, 100); }
  fs::path add(const std::string& name, DdsRole role, int days = 100) {
    add_enclave(store_, name, role, days);
    return store_ / "enclaves" / name;
  }

  TempFolder folder_;
  fs::path store_ = folder_ / "keys";
};

TEST_F(Keystore, OpensslVerifiesEveryCertificateAndDocumentByItsOwnCaAlone) {
  for (const DdsRole role : {DdsRole::look, DdsRole::stop, DdsRole::command, DdsRole::vehicle,
                             DdsRole::ros, DdsRole::bridge}) {
    const fs::path one = add(kDdsRoles[static_cast<std::size_t>(role)], role);
    const auto file = [&](const char* name) { return (one / name).string(); };
    const std::string certificate = file(dds::kCertificate), identity = file(dds::kIdentityCa),
                      permissions = file(dds::kPermissionsCa);
    EXPECT_TRUE(openssl("verify -x509_strict -CAfile " + identity + " " + certificate));
    EXPECT_FALSE(openssl("verify -CAfile " + permissions + " " + certificate));
    for (const char* document : {dds::kGovernance, dds::kPermissions}) {
      const std::string verify = "smime -verify -text -in " + file(document) + " -CAfile ";
      EXPECT_TRUE(openssl(verify + permissions)) << document;
      EXPECT_FALSE(openssl(verify + identity)) << document;
    }
    EXPECT_EQ(
        std::system(
            ("openssl x509 -noout -text -in " + certificate + " | grep -q prime256v1").c_str()),
        0);
    const auto read = dds::read_enclave(one);
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(read->name, one.filename());
    EXPECT_TRUE(read->warnings.empty()) << read->warnings.front();
  }
}

TEST_F(Keystore, KeysAreForTheirOwnerAndThoseOfTheCasStayInTheKeystore) {
  const fs::path one = add("pilot", DdsRole::command);
  EXPECT_EQ(mode_of(one / dds::kKey), 0600u);
  EXPECT_EQ(mode_of(store_ / "private"), 0700u);
  for (const char* ca : {"identity_ca.key.pem", "permissions_ca.key.pem"}) {
    EXPECT_EQ(mode_of(store_ / "private" / ca), 0600u);
    EXPECT_FALSE(fs::exists(one / ca));
  }
  for (const fs::directory_entry& file : fs::directory_iterator(one))
    EXPECT_FALSE(file.is_symlink()) << file << ": the folder alone goes to a vehicle";
}

TEST_F(Keystore, ARoleSaysWhatItMay) {
  const auto published = [&](DdsRole role) {
    const fs::path one = add(kDdsRoles[static_cast<std::size_t>(role)], role);
    const std::string text = content(one / "permissions.xml");
    const std::size_t from = text.find("<publish>"), to = text.find("</publish>");
    return from == std::string::npos ? std::string() : text.substr(from, to - from);
  };
  using testing::Not;
  EXPECT_EQ(published(DdsRole::look), "");
  EXPECT_THAT(published(DdsRole::stop),
              AllOf(HasSubstr("lss/stop"), Not(HasSubstr("lss/command"))));
  EXPECT_THAT(published(DdsRole::command),
              AllOf(HasSubstr("lss/command<"), Not(HasSubstr("lss/status"))));
  EXPECT_THAT(published(DdsRole::vehicle),
              AllOf(HasSubstr("lss/status"), Not(HasSubstr("lss/command<"))));
  EXPECT_THAT(published(DdsRole::ros), AllOf(HasSubstr("rt/*"), Not(HasSubstr("lss/"))));
  EXPECT_THAT(published(DdsRole::bridge),
              AllOf(HasSubstr("rt/*"), HasSubstr("lss/command<"), Not(HasSubstr("lss/status"))));
}

TEST_F(Keystore, NothingIsOverwrittenAndNothingIsLeftOfWhatFailed) {
  add("pilot", DdsRole::command);
  const std::string before = content(store_ / "enclaves/pilot/key.pem");
  EXPECT_THAT(failure_of([&] { add("pilot", DdsRole::look); }), HasSubstr("is there already"));
  EXPECT_THAT(failure_of([&] { create_keystore(store_, 1); }), HasSubstr("is there already"));
  EXPECT_EQ(content(store_ / "enclaves/pilot/key.pem"), before);
  EXPECT_THAT(failure_of([&] { create_keystore(folder_ / "no/such", 1); }),
              HasSubstr("No such file"));
  fs::remove(store_ / "enclaves" / dds::kGovernance);
  EXPECT_ANY_THROW(add("second", DdsRole::look));
  for (const fs::directory_entry& one : fs::directory_iterator(store_ / "enclaves"))
    EXPECT_THAT(one.path().filename().string(), testing::Not(testing::StartsWith("second")));
}

class Revocation : public Keystore {
 protected:
  fs::path public_list() const { return store_ / "public" / dds::kRevoked; }
  // Of the list that `by` has.
  bool refuses(const fs::path& by, const fs::path& certificate) const {
    return !openssl("verify -crl_check -CAfile " + (store_ / "public" / dds::kIdentityCa).string() +
                    " -CRLfile " + (by / dds::kRevoked).string() + " " + certificate.string());
  }
  // A copy of the certificate of an enclave.
  fs::path stolen(const fs::path& enclave) const {
    const fs::path copy = folder_ / ("stolen-" + enclave.filename().string());
    fs::copy_file(enclave / dds::kCertificate, copy);
    return copy;
  }
};

TEST_F(Revocation, ARevokedCertificateIsOnTheListOfEveryEnclaveAndItsNameIsFree) {
  const fs::path pilot = add("pilot", DdsRole::command), lost = add("lost", DdsRole::command);
  const fs::path lost_copy = stolen(lost), pilot_copy = stolen(pilot);
  EXPECT_FALSE(refuses(pilot, lost_copy));
  revoke_enclave(store_, "lost");
  EXPECT_FALSE(fs::exists(lost));
  EXPECT_TRUE(refuses(pilot, lost_copy));
  EXPECT_FALSE(refuses(pilot, pilot_copy));

  const fs::path again = add("lost", DdsRole::command);
  revoke_enclave(store_, "pilot");  // the list grows
  const auto read = dds::read_enclave(again);
  ASSERT_TRUE(read) << read.error();
  EXPECT_TRUE(read->warnings.empty()) << read->warnings.front();
  EXPECT_TRUE(refuses(again, lost_copy));
  EXPECT_TRUE(refuses(again, pilot_copy));
  EXPECT_FALSE(refuses(again, again / dds::kCertificate));
  for (const fs::directory_entry& one : fs::directory_iterator(store_ / "revoked")) {
    fs::copy_file(again / dds::kRevoked, one.path() / dds::kRevoked,
                  fs::copy_options::overwrite_existing);
    EXPECT_THAT(dds::read_enclave(one.path()).error(), HasSubstr("is revoked"));
  }
}

// Signed permissions are of a name and stay valid.
TEST_F(Revocation, ARevokedNameIsAddedAgainWithItsRoleOnly) {
  add("driver", DdsRole::command);
  revoke_enclave(store_, "driver");
  EXPECT_THAT(failure_of([&] { add("driver", DdsRole::look); }), HasSubstr("had the role command"));
  EXPECT_EQ(failure_of([&] { add("driver", DdsRole::command); }), "");
}

TEST_F(Revocation, ANameRevokedByItsFileIsAddedAgainOnlyWithTheRoleThatIsBesideTheFile) {
  const fs::path driver = add("driver", DdsRole::command), guest = add("guest", DdsRole::command);
  const fs::path copy = folder_ / "driver";  // of the whole enclave
  fs::copy(driver, copy);
  const fs::path guest_copy = stolen(guest);
  for (const fs::path& gone : {driver, guest}) fs::remove_all(gone);
  for (int i = 0; i < 2; ++i) {
    revoke_enclave(store_, "", copy / dds::kCertificate);
    revoke_enclave(store_, "", guest_copy);
  }
  EXPECT_THAT(failure_of([&] { add("driver", DdsRole::look); }), HasSubstr("had the role command"));
  for (const DdsRole role : {DdsRole::look, DdsRole::command})
    EXPECT_THAT(failure_of([&] { add("guest", role); }),
                HasSubstr("had a role that this keystore does not know"));
  EXPECT_EQ(failure_of([&] { add("driver", DdsRole::command); }), "");
}

TEST_F(Revocation, PermissionsOfAnotherNameBesideTheFileDoNotDecideItsRole) {
  const fs::path driver = add("driver", DdsRole::look), guest = add("guest", DdsRole::command);
  const fs::path file = driver / "guest.pem";
  fs::copy_file(guest / dds::kCertificate, file);
  fs::remove_all(guest);
  revoke_enclave(store_, "", file);
  EXPECT_THAT(failure_of([&] { add("guest", DdsRole::look); }),
              HasSubstr("had a role that this keystore does not know"));
}

TEST_F(Revocation, AnEnclaveWhoseCertificateWasRevokedByACopyIsRevokedByItsName) {
  const fs::path driver = add("driver", DdsRole::command);
  revoke_enclave(store_, "", stolen(driver));
  EXPECT_EQ(failure_of([&] { revoke_enclave(store_, "driver"); }), "");
  EXPECT_FALSE(fs::exists(driver));
  EXPECT_EQ(failure_of([&] { add("driver", DdsRole::command); }), "");
}

TEST_F(Revocation, AListThatIsLostOrOldForgetsNothing) {
  const fs::path one = add("one", DdsRole::command), a = add("a", DdsRole::look),
                 b = add("b", DdsRole::look), c = add("c", DdsRole::look);
  const fs::path a_copy = stolen(a), b_copy = stolen(b), c_copy = stolen(c);
  const std::string old = content(public_list());
  revoke_enclave(store_, "a");
  put_content(public_list(), old);
  revoke_enclave(store_, "b");
  fs::remove(public_list());
  revoke_enclave(store_, "c");
  for (const fs::path& copy : {a_copy, b_copy, c_copy}) EXPECT_TRUE(refuses(one, copy)) << copy;
}

TEST_F(Revocation, ACertificateThatIsNoLongerInTheKeystoreIsRevokedByItsFile) {
  const fs::path one = add("one", DdsRole::command), gone = add("gone", DdsRole::command);
  const fs::path copy = stolen(gone);
  fs::remove_all(gone);
  const fs::path now = add("gone", DdsRole::command);
  revoke_enclave(store_, "", copy);
  EXPECT_TRUE(refuses(one, copy));
  EXPECT_FALSE(refuses(one, now / dds::kCertificate));
  EXPECT_TRUE(fs::exists(now));
  EXPECT_THAT(failure_of([&] { revoke_enclave(store_, "", folder_ / "none"); }),
              HasSubstr("is no certificate in PEM"));
}

TEST_F(Revocation, AnEnclaveDeeperInTheKeystoreGetsTheListAndOneThatCannotIsNamed) {
  const fs::path one = add("one", DdsRole::command), other = add("other", DdsRole::look),
                 lost = add("lost", DdsRole::look);
  const fs::path copy = stolen(lost);
  fs::create_directories(store_ / "enclaves" / "rover");
  fs::rename(one, store_ / "enclaves" / "rover" / "one");  // as in ROS 2
  fs::create_directory(other / (std::string(dds::kRevoked) + ".new"));
  put_content(other / (std::string(dds::kRevoked) + ".new") / "x", "");  // not to be replaced
  EXPECT_THAT(failure_of([&] { revoke_enclave(store_, "lost"); }),
              AllOf(HasSubstr("it is revoked, but not all"), HasSubstr("enclaves/other")));
  EXPECT_TRUE(refuses(store_ / "enclaves" / "rover" / "one", copy));
  EXPECT_FALSE(fs::exists(lost));
}

TEST_F(Revocation, WhatCannotBeRevokedIsRefusedAndADamagedListIsNoEmptyOne) {
  const fs::path one = add("one", DdsRole::command), other = add("other", DdsRole::look);
  for (const char* name : {"", ".", "..", "nobody", "../enclaves/one", "governance.xml"})
    EXPECT_THAT(failure_of([&] { revoke_enclave(store_, name); }), HasSubstr("is no enclave"))
        << name;
  revoke_enclave(store_, "other");
  const std::string list = content(public_list());
  put_content(public_list(), list.substr(0, list.size() / 2));
  for (const auto& change : std::initializer_list<std::function<void()>>{
           [&] { revoke_enclave(store_, "one"); }, [&] { add("new", DdsRole::look); }})
    EXPECT_THAT(failure_of(change),
                HasSubstr("is no list of revoked certificates of this keystore"));
  EXPECT_TRUE(fs::exists(one));
  put_content(one / dds::kRevoked, "");
  EXPECT_THAT(dds::read_enclave(one).error(), HasSubstr("is no list of revoked certificates"));
  const fs::path strange = folder_ / "strange";
  create_keystore(strange, 100);
  put_content(one / dds::kRevoked, content(strange / "public" / dds::kRevoked));
  EXPECT_THAT(dds::read_enclave(one).error(), HasSubstr("is not signed by identity_ca.cert.pem"));
  fs::remove(one / dds::kRevoked);
  ASSERT_TRUE(dds::read_enclave(one));
  EXPECT_THAT(dds::read_enclave(one)->warnings.front(), HasSubstr("crl.pem is missing"));
}

TEST_F(Keystore, NamesThatTheRoleCannotUseAreRefused) {
  EXPECT_THAT(failure_of([&] { add("-x", DdsRole::look); }), HasSubstr("begins with -"));
  EXPECT_THAT(failure_of([&] { add("a-name-of-16-cha", DdsRole::vehicle); }),
              HasSubstr("longer than a vehicle_id, 15 characters"));
  EXPECT_EQ(failure_of([&] { add("a-name-of-15-ch", DdsRole::vehicle); }), "");
  for (const char* name : {"a-node", "9node"})
    EXPECT_THAT(failure_of([&] { add(name, DdsRole::ros); }), HasSubstr("no name in ROS 2"));
}

TEST_F(Keystore, NamesThatAreNoSourceAreRefused) {
  for (const char* name : {"", "a:b", "../x", "a b", "x/y", "a-name-of-24-characters-"})
    EXPECT_THAT(failure_of([&] { add(name, DdsRole::look); }), HasSubstr("letters, digits"))
        << name;
  EXPECT_THAT(failure_of([&] { add_enclave(folder_ / "none", "x", DdsRole::look, 1); }),
              HasSubstr("cannot be read"));
}

TEST_F(Keystore, TheListHasRolesExpiryAndWhatIsUnusable) {
  add("b", DdsRole::stop, 40);
  fs::resize_file(add("a", DdsRole::vehicle) / dds::kPermissions, 700);
  const auto list = list_keystore(store_);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].name, "a");
  EXPECT_THAT(list[0].fault, HasSubstr(dds::kPermissions));
  EXPECT_EQ(list[1].name, "b");
  EXPECT_EQ(list[1].role, "stop");
  const std::time_t until = std::time(nullptr) + 40 * 86'400;
  char day[16];
  std::strftime(day, sizeof day, "%Y-%m-%d", std::gmtime(&until));
  EXPECT_EQ(list[1].not_after, day);
  EXPECT_EQ(list[1].fault, "");
}

TEST_F(Keystore, AnEnclaveThatDoesNotFitTogetherIsRefusedWithTheFile) {
  const fs::path one = add("one", DdsRole::command), other = add("other", DdsRole::vehicle);
  const auto fault = [&] {
    const auto read = dds::read_enclave(one);
    return read ? "" : read.error();
  };
  const auto swapped = [&](const char* file, const std::string& text) {
    const std::string own = content(one / file);
    put_content(one / file, text);
    std::string found = fault();
    put_content(one / file, own);
    return found;
  };
  EXPECT_EQ(fault(), "");
  EXPECT_THAT(swapped(dds::kKey, content(other / dds::kKey)), HasSubstr("is not the key of"));
  EXPECT_THAT(swapped(dds::kKey, "none"), HasSubstr("is no private key"));
  EXPECT_THAT(swapped(dds::kIdentityCa, content(one / dds::kPermissionsCa)),
              HasSubstr("is not signed by"));
  EXPECT_THAT(swapped(dds::kPermissionsCa, content(one / dds::kIdentityCa)),
              HasSubstr("is not signed by"));
  std::string altered = content(one / dds::kPermissions);
  altered.replace(altered.find("lss/command"), 3, "LSS");
  EXPECT_THAT(swapped(dds::kPermissions, altered), HasSubstr("it was altered"));
  EXPECT_THAT(swapped(dds::kGovernance, ""), HasSubstr("is no signed document"));
  fs::permissions(one / dds::kKey, fs::perms::others_read, fs::perm_options::add);
  EXPECT_THAT(fault(), HasSubstr("chmod 600"));
}

// CVE-2023-24011: the plugin of Cyclone DDS takes a document whose signer has a certificate of the
// permissions CA. Keystores of ROS 2 have one CA, so every participant is such a signer.
TEST_F(Keystore, ADocumentSignedByACertificateOfTheCaIsNotSignedByTheCa) {
  const fs::path one = add("one", DdsRole::look);
  const auto file = [&](const char* name) { return (one / name).string(); };
  fs::copy_file(file(dds::kIdentityCa), file(dds::kPermissionsCa),
                fs::copy_options::overwrite_existing);
  const auto sign = [&](const fs::path& text, const char* document, const std::string& certificate,
                        const std::string& key) {
    return openssl(fmt::format("smime -sign -text -in {} -out {} -signer {} -inkey {}",
                               text.string(), file(document), certificate, key));
  };
  const std::string ca = file(dds::kIdentityCa),
                    ca_key = (store_ / "private/identity_ca.key.pem").string();
  ASSERT_TRUE(sign(store_ / "enclaves/governance.xml", dds::kGovernance, ca, ca_key));
  ASSERT_TRUE(sign(one / "permissions.xml", dds::kPermissions, ca, ca_key));
  const auto whole = dds::read_enclave(one);
  ASSERT_TRUE(whole) << whole.error();
  ASSERT_EQ(whole->warnings.size(), 1u);
  EXPECT_THAT(whole->warnings.front(), HasSubstr("CVE-2023-24011"));

  ASSERT_TRUE(
      sign(one / "permissions.xml", dds::kPermissions, file(dds::kCertificate), file(dds::kKey)));
  EXPECT_TRUE(openssl("smime -verify -text -in " + file(dds::kPermissions) + " -CAfile " + ca))
      << "the attack: this is what the plugin checks";
  const auto attacked = dds::read_enclave(one);
  ASSERT_FALSE(attacked);
  EXPECT_THAT(attacked.error(), HasSubstr("permissions_ca.cert.pem itself"));
}

}  // namespace
}  // namespace lss::cli
