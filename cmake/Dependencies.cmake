# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Every outside library in one place, as imported targets (headers are SYSTEM: their warnings are theirs).
# It is installed too: clusterfusionConfig.cmake finds by it what the libraries link to.
find_package(Threads REQUIRED)
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(TBB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Ceres REQUIRED)
find_package(GDAL REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Protobuf 3.12 REQUIRED)
find_package(mrpt-obs REQUIRED)
find_package(mrpt-maps REQUIRED)
find_package(mrpt-graphs REQUIRED)
find_package(mrpt-opengl REQUIRED)
find_package(octomap REQUIRED)
find_package(embree 3.13 REQUIRED)

find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs features2d calib3d flann)
# OpenCV, PCL, GeographicLib and OctoMap export variables or plain targets: one imported target each.
add_library(cf_opencv INTERFACE IMPORTED GLOBAL)
target_link_libraries(cf_opencv INTERFACE ${OpenCV_LIBS})
target_include_directories(cf_opencv SYSTEM INTERFACE ${OpenCV_INCLUDE_DIRS})

list(APPEND CMAKE_MODULE_PATH /usr/share/cmake/geographiclib)
find_package(GeographicLib REQUIRED)
add_library(cf_geographiclib INTERFACE IMPORTED GLOBAL)
target_link_libraries(cf_geographiclib INTERFACE ${GeographicLib_LIBRARIES})
target_include_directories(cf_geographiclib SYSTEM INTERFACE ${GeographicLib_INCLUDE_DIRS})

# `io` would drag in VTK; common, kdtree and filters do not.
find_package(PCL 1.13 REQUIRED COMPONENTS common kdtree filters)
add_library(cf_pcl INTERFACE IMPORTED GLOBAL)
target_link_libraries(cf_pcl INTERFACE ${PCL_LIBRARIES})
target_include_directories(cf_pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})

add_library(cf_octomap INTERFACE IMPORTED GLOBAL)
target_link_libraries(cf_octomap INTERFACE ${OCTOMAP_LIBRARIES})
target_include_directories(cf_octomap SYSTEM INTERFACE ${OCTOMAP_INCLUDE_DIRS})

# libjpeg-turbo: its own colour orders are used.
find_package(JPEG REQUIRED)

find_path(CF_ZSTD_INCLUDE_DIR zstd.h REQUIRED)
find_library(CF_ZSTD_LIBRARY zstd REQUIRED)
add_library(cf_zstd INTERFACE IMPORTED GLOBAL)
target_link_libraries(cf_zstd INTERFACE ${CF_ZSTD_LIBRARY})
target_include_directories(cf_zstd SYSTEM INTERFACE ${CF_ZSTD_INCLUDE_DIR})
