#pragma once

// Owners of OpenSSL's objects.

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>

namespace lss::openssl {

template <auto F>
using With = decltype([](auto* one) { F(one); });
using Bio = std::unique_ptr<BIO, With<BIO_free>>;
using Certificate = std::unique_ptr<X509, With<X509_free>>;
using RevocationList = std::unique_ptr<X509_CRL, With<X509_CRL_free>>;
using Key = std::unique_ptr<EVP_PKEY, With<EVP_PKEY_free>>;

}  // namespace lss::openssl
