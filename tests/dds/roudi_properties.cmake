# Read by ctest after the cases were discovered: there can be one RouDi on a machine.
set_tests_properties(${test_dds_roudi_TESTS} PROPERTIES RESOURCE_LOCK roudi)
