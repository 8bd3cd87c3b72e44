// SPDX-License-Identifier: Apache-2.0
// tinygltf in a namespace of its own: Debian's libdraco exports an older tinygltf, and a program that links both would
// mix them.
#pragma once

#define tinygltf spheretree_tinygltf
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
