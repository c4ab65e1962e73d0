"""Enclaves of DDS Security around a scenario: keystores of lss-cli, those of ROS 2, and a stranger's."""

import glob
import os

from programs import run

PLUGINS = next((os.path.dirname(path) for path in glob.glob("/usr/lib/*/*/libdds_security_auth.so") +
                glob.glob("/usr/lib/*/libdds_security_auth.so")), None)
ROLES = {"zebro-1": "vehicle", "zebro-2": "vehicle", "pilot": "command", "other": "command", "watcher": "look", "stopper": "stop"}
POLICY = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_{}.xsd">{}</dds>
"""
EVERYTHING = """<permissions><grant name="/{0}"><subject_name>CN={0}</subject_name>
<validity><not_before>{1}</not_before><not_after>2043-10-26T22:45:30</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<publish><topics><topic>*</topic></topics></publish><subscribe><topics><topic>*</topic></topics></subscribe>
</allow_rule><default>DENY</default></grant></permissions>"""
OPEN = """<domain_access_rules><domain_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<allow_unauthenticated_participants>{0}</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>{1}</discovery_protection_kind><liveliness_protection_kind>{1}</liveliness_protection_kind>
<rtps_protection_kind>{2}</rtps_protection_kind>
<topic_access_rules><topic_rule><topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection><enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control>
<enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>{1}</metadata_protection_kind><data_protection_kind>{1}</data_protection_kind>
</topic_rule></topic_access_rules></domain_rule></domain_access_rules>"""
ROS2_GOVERNANCE = OPEN.format("false", "ENCRYPT", "SIGN")


def uri(enclave):
    """CYCLONEDDS_URI of a program that is not ours."""
    def file(name):
        return f"file:{os.path.join(enclave, name)}"

    def library(name, what):
        return (f'<Library path="{PLUGINS}/libdds_security_{name}.so" initFunction="init_{what}" '
                f'finalizeFunction="finalize_{what}"/>')
    return ("<Security><Authentication>" + library("auth", "authentication") +
            f"<IdentityCA>{file('identity_ca.cert.pem')}</IdentityCA>"
            f"<IdentityCertificate>{file('cert.pem')}</IdentityCertificate><PrivateKey>{file('key.pem')}</PrivateKey>"
            "</Authentication><Cryptographic>" + library("crypto", "crypto") + "</Cryptographic><AccessControl>" +
            library("ac", "access_control") +
            f"<PermissionsCA>{file('permissions_ca.cert.pem')}</PermissionsCA>"
            f"<Governance>{file('governance.p7s')}</Governance><Permissions>{file('permissions.p7s')}</Permissions>"
            "</AccessControl></Security>")


def openssl(*words):
    result = run(["openssl", *words], os.environ, 30)
    if result.code != 0:
        raise AssertionError(f"openssl {' '.join(words)}: {result.err}")


def sign(text, document, certificate, key):
    openssl("smime", "-sign", "-text", "-in", text, "-out", document, "-signer", certificate, "-inkey", key)


def write_policy(folder, kind, text):
    path = os.path.join(folder, f"{kind}.xml")
    with open(path, "w", encoding="ascii") as file:
        file.write(POLICY.format(kind, text))
    return path


def make_ca(folder, name):
    key, certificate = os.path.join(folder, f"{name}.key.pem"), os.path.join(folder, f"{name}.cert.pem")
    openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "3650",
            "-subj", f"/CN={name}", "-keyout", key, "-out", certificate)
    return certificate, key


def make_ros2_keystore(folder, names):
    """As `ros2 security create_keystore` and `create_enclave` lay it out: one CA under three names, links to public/."""
    for part in ("public", "private", "enclaves"):
        os.makedirs(os.path.join(folder, part))
    private = os.path.join(folder, "private")
    certificate, key = make_ca(private, "ca")
    os.rename(certificate, os.path.join(folder, "public", "ca.cert.pem"))
    certificate = os.path.join(folder, "public", "ca.cert.pem")
    for link in ("identity_ca", "permissions_ca"):
        os.symlink("ca.cert.pem", os.path.join(folder, "public", f"{link}.cert.pem"))
    enclaves = os.path.join(folder, "enclaves")
    governance = os.path.join(enclaves, "governance.p7s")
    sign(write_policy(enclaves, "governance", ROS2_GOVERNANCE), governance, certificate, key)
    for name in names:
        enclave = os.path.join(enclaves, name)
        os.makedirs(enclave)
        for link in ("identity_ca", "permissions_ca"):
            os.symlink(os.path.relpath(os.path.join(folder, "public", f"{link}.cert.pem"), enclave),
                       os.path.join(enclave, f"{link}.cert.pem"))
        os.symlink(os.path.relpath(governance, enclave), os.path.join(enclave, "governance.p7s"))
        own_key, request = os.path.join(enclave, "key.pem"), os.path.join(enclave, "request.pem")
        openssl("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj", f"/CN=\\/{name}",
                "-keyout", own_key, "-out", request)
        openssl("x509", "-req", "-in", request, "-CA", certificate, "-CAkey", key, "-CAcreateserial", "-days", "3650",
                "-out", os.path.join(enclave, "cert.pem"))
        os.remove(request)
        os.chmod(own_key, 0o600)
        sign(write_policy(enclave, "permissions", EVERYTHING.format("/" + name, "2013-10-26T00:00:00")),
             os.path.join(enclave, "permissions.p7s"), certificate, key)


def make_rogue(enclave, name, folder):
    """A participant that may look writes documents of its own that let it do everything, and its own plugins believe
    them. It signs with its own key, as CVE-2023-24011 is published."""
    os.makedirs(folder)
    for file in ("identity_ca.cert.pem", "cert.pem", "key.pem"):
        os.symlink(os.path.join(enclave, file), os.path.join(folder, file))
    os.symlink(os.path.join(enclave, "identity_ca.cert.pem"), os.path.join(folder, "permissions_ca.cert.pem"))
    own = (os.path.join(enclave, "cert.pem"), os.path.join(enclave, "key.pem"))
    sign(write_policy(folder, "permissions", EVERYTHING.format(name, "2013-10-26T00:00:00")),
         os.path.join(folder, "permissions.p7s"), *own)
    sign(write_policy(folder, "governance", ROS2_GOVERNANCE), os.path.join(folder, "governance.p7s"), *own)


class Enclaves:
    """With a Scenario, whose lss-cli is the pilot's."""

    keystore = None

    def setUp(self):
        super().setUp()
        if PLUGINS is None:
            self.skipTest("skipped: this Cyclone DDS has no security plugins")

    def make_keystore(self, name="keys", roles=None):
        folder = os.path.join(self.folder, name)
        self.cli_ok("keystore", "create", folder)
        for enclave, role in (roles or ROLES).items():
            self.cli_ok("keystore", "add", folder, enclave, "--role", role)
        return folder

    def enclave(self, name, keystore=None):
        return os.path.join(keystore or self.keystore, "enclaves", name)

    def environment(self, **more):
        own = {"LSS_ENCLAVE": self.enclave("pilot")} if self.keystore else {}
        return super().environment(**{**own, **more})

    def secured(self, **changes):
        return self.write_config(enclave=f'"{self.enclave("zebro-1")}"', **changes)

    def as_enclave(self, name, *words, limit_s=60):
        # Secured daemons need seconds to know each other on a busy machine.
        return self.cli("--enclave", self.enclave(name), "--timeout", "20s", *words, limit_s=limit_s)
