# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
"""Reads a LAS file by ASPRS' LAS 1.4 specification (revision 15) alone, knowing nothing of the
program that wrote it, checks that it keeps to the specification, and prints what it holds as JSON.

    python3 read_las.py FILE.las [POINTS_TO_PRINT]
"""
import json
import struct
import sys

HEADER = struct.Struct(
    "<4s"  # file signature
    "H H"  # file source id, global encoding
    "I H H 8s"  # project id (GUID)
    "B B"  # version major, minor
    "32s 32s"  # system identifier, generating software
    "H H H"  # creation day of year, year, header size
    "I I B H"  # offset to point data, number of VLRs, point data record format and length
    "I 5I"  # legacy counts
    "3d 3d"  # scale factors, offsets
    "6d"  # max x, min x, max y, min y, max z, min z
    "Q Q I"  # start of waveform data, start and number of EVLRs
    "Q 15Q"  # number of point records, by return
)
RECORD = struct.Struct("<H 16s H H 32s")
POINT_7 = struct.Struct("<3i H B B B B h H d 3H")


def text(field):
    return field.split(b"\0", 1)[0].decode("ascii")


def require(condition, what):
    if not condition:
        sys.exit(what)


def main():
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    wanted = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    require(HEADER.size == 375, "the header's layout here is wrong")
    h = HEADER.unpack_from(data, 0)
    signature, _, encoding = h[0:3]
    major, minor, system, software = h[7:11]
    header_size, points_at, record_count, point_format, point_size = h[13:18]
    legacy = h[18:24]
    scale, offset = h[24:27], h[27:30]
    max_x, min_x, max_y, min_y, max_z, min_z = h[30:36]
    waveform, _, extended = h[36:39]
    count, by_return = h[39], h[40:55]
    require(signature == b"LASF", "the signature is wrong")
    require((major, minor) == (1, 4), "the version is not 1.4")
    require(header_size == 375, "the header size is wrong")
    require(point_format == 7 and point_size == POINT_7.size == 36, "not point format 7")
    require(encoding & 1 << 4, "point formats from 6 on need the WKT bit")
    require(not any(legacy), "legacy counts must be 0 for point formats from 6 on")
    require(not waveform and not extended, "there are neither wave forms nor extended records")
    require(sum(by_return) == count, "the counts by return do not add up")

    wkt = None
    position = header_size
    for _ in range(record_count):
        reserved, user, number, length, _ = RECORD.unpack_from(data, position)
        require(reserved == 0, "reserved must be 0")
        position += RECORD.size
        if text(user) == "LASF_Projection" and number == 2112:
            payload = data[position : position + length]
            require(payload.endswith(b"\0"), "the WKT does not end in a zero")
            wkt = text(payload)
        position += length
    require(position <= points_at, "records run into the points")
    require(points_at + count * point_size == len(data), "the file's size does not fit its count")

    low, high = [float("inf")] * 3, [float("-inf")] * 3
    returns = [0] * 15
    classes = set()
    points = []
    for i in range(count):
        p = POINT_7.unpack_from(data, points_at + i * point_size)
        xyz = [p[axis] * scale[axis] + offset[axis] for axis in range(3)]
        low = [min(a, b) for a, b in zip(low, xyz)]
        high = [max(a, b) for a, b in zip(high, xyz)]
        number, of = p[4] & 15, p[4] >> 4
        require(1 <= number <= of <= 15, "a return number is wrong")
        returns[number - 1] += 1
        classes.add(p[6])
        if i < wanted:
            points.append({"xyz": xyz, "user_data": p[7], "gps_time": p[10], "rgb": list(p[11:14])})
    require(tuple(returns) == by_return, "the counts by return are wrong")
    if count:
        require(
            all(abs(a - b) < 1e-6 for a, b in zip(low + high, (min_x, min_y, min_z, max_x, max_y, max_z))),
            "the bounds are not those of the points",
        )
    json.dump(
        {
            "system": text(system),
            "software": text(software),
            "count": count,
            "scale": scale,
            "offset": offset,
            "low": [min_x, min_y, min_z],
            "high": [max_x, max_y, max_z],
            "classes": sorted(classes),
            "wkt": wkt,
            "points": points,
        },
        sys.stdout,
    )


main()
