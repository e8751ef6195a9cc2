# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# cf_library(NAME SOURCES … [PUBLIC …] [PRIVATE …])   target cf_NAME, alias cf::NAME, installed so
# cf_application(NAME SOURCES … LINKS …)              executable NAME
# cf_test(LIB/FILE [LINKS …])                         tests/LIB/FILE_test.cpp as CTest LIB/FILE

add_library(cf_compile_options INTERFACE)
target_compile_options(cf_compile_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  -Wno-psabi -ffp-contract=off $<$<BOOL:${CF_WERROR}>:-Werror>)
if(CF_BUILD_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "CF_BUILD_FUZZERS needs clang: configure with -DCMAKE_CXX_COMPILER=clang++")
  endif()
  set(CF_SANITIZE address,undefined)
  target_compile_options(cf_compile_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(CF_SANITIZE)
  target_compile_options(cf_compile_options INTERFACE
    -fsanitize=${CF_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g)
  target_link_options(cf_compile_options INTERFACE -fsanitize=${CF_SANITIZE})
endif()

function(cf_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(cf_${name} STATIC ${ARG_SOURCES})
  add_library(cf::${name} ALIAS cf_${name})
  target_include_directories(cf_${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/clusterfusion>)
  target_link_libraries(cf_${name}
    PUBLIC ${ARG_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:cf_compile_options> ${ARG_PRIVATE})
  set_target_properties(cf_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS cf_${name} EXPORT clusterfusionTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/clusterfusion COMPONENT dev)
endfunction()

function(cf_application name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE cf_compile_options ${ARG_LINKS})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/apps)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
endfunction()

function(cf_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "LINKS" ${ARGN})
  string(REPLACE "/" "_" target "test_${name}")
  add_executable(${target} ${PROJECT_SOURCE_DIR}/tests/${name}_test.cpp)
  target_link_libraries(${target} PRIVATE cf_compile_options ${ARG_LINKS} GTest::gtest_main)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${target} PRIVATE
    CF_REAL_DATA="${CF_REAL_DATA}" CF_BIN_DIR="${PROJECT_BINARY_DIR}/bin"
    CF_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_test(NAME ${name} COMMAND ${target})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()
