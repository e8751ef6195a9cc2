# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# `cmake --install` beyond the targets, and CPack's Debian packages (docs/install.md):
#   runtime   programs, demo, scenes, documents   -> clusterfusion
#   dev       libraries, headers, CMake files     -> clusterfusion-dev
include(CMakePackageConfigHelpers)

set(cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/clusterfusion)
set(share_dir ${CMAKE_INSTALL_DATADIR}/clusterfusion)
set(doc_dir ${CMAKE_INSTALL_DATADIR}/doc/clusterfusion)

install(EXPORT clusterfusionTargets NAMESPACE cf:: DESTINATION ${cmake_dir} COMPONENT dev)
configure_package_config_file(cmake/clusterfusionConfig.cmake.in
  ${PROJECT_BINARY_DIR}/clusterfusionConfig.cmake INSTALL_DESTINATION ${cmake_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/clusterfusionConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/clusterfusionConfig.cmake
  ${PROJECT_BINARY_DIR}/clusterfusionConfigVersion.cmake
  cmake/Dependencies.cmake
  DESTINATION ${cmake_dir} COMPONENT dev)

install(FILES config.ini DESTINATION ${share_dir} COMPONENT runtime)
install(DIRECTORY rawlogs scenes DESTINATION ${share_dir} COMPONENT runtime)
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${doc_dir} COMPONENT runtime)
install(FILES LICENSE DESTINATION ${doc_dir} RENAME copyright COMPONENT runtime)
install(DIRECTORY docs DESTINATION ${doc_dir} COMPONENT runtime)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/clusterfusion-dev RENAME copyright
  COMPONENT dev)

# What the static libraries need of the packages that building needs: scripts/packages.txt.
file(STRINGS scripts/packages.txt packages REGEX "^lib.*-dev$|^nlohmann-json3-dev$|^protobuf-")
list(REMOVE_ITEM packages libgtest-dev libcli11-dev)
string(REPLACE ";" ", " dev_depends "${packages}")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME clusterfusion)
set(CPACK_PACKAGE_CONTACT "ClusterFusion authors <clusterfusion@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME clusterfusion)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
# Found when needed, not linked: EGL and Mesa's software driver draw the pictures.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "libegl1, libegl-mesa0, libgl1-mesa-dri")
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION 
"cf-import makes recordings of photos, cf-run maps them, cf-snapshot draws
the map, cf-eval measures it against references, ground points, or an
earlier map, cf-simulate flies over made-up towns. A demo is in
/usr/share/clusterfusion.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME clusterfusion-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${dev_depends}")
set(CPACK_DEBIAN_DEV_DESCRIPTION 
"Static libraries and headers of ClusterFusion, for
find_package(clusterfusion) in CMake.")
include(CPack)
