# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# cmake -DINPUT=FILE -DOUTPUT=FILE.cpp -DNAME=kText -P EmbedText.cmake
# OUTPUT defines extern const char* const cf::NAME: the text of INPUT, which must not hold )CFTEXT".
file(READ "${INPUT}" text)
file(WRITE "${OUTPUT}"
  "namespace cf {\nextern const char* const ${NAME};\n"
  "const char* const ${NAME} = R\"CFTEXT(${text})CFTEXT\";\n}  // namespace cf\n")
