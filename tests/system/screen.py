"""Reads and overwrites pixels of an X display, to check what the SLM receives."""
import ctypes

import numpy

ZPIXMAP = 2


class XImage(ctypes.Structure):
    _fields_ = [("width", ctypes.c_int), ("height", ctypes.c_int), ("xoffset", ctypes.c_int), ("format", ctypes.c_int),
                ("data", ctypes.c_void_p), ("byte_order", ctypes.c_int), ("bitmap_unit", ctypes.c_int),
                ("bitmap_bit_order", ctypes.c_int), ("bitmap_pad", ctypes.c_int), ("depth", ctypes.c_int),
                ("bytes_per_line", ctypes.c_int), ("bits_per_pixel", ctypes.c_int)]


def grab(display, x, y, width, height):
    """The rectangle's pixels as an array of height x width x 3 (blue, green, red)."""
    xlib = ctypes.CDLL("libX11.so.6")
    xlib.XOpenDisplay.restype = ctypes.c_void_p
    xlib.XDefaultRootWindow.restype = ctypes.c_ulong
    xlib.XDefaultRootWindow.argtypes = [ctypes.c_void_p]
    xlib.XGetImage.restype = ctypes.POINTER(XImage)
    xlib.XGetImage.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_int, ctypes.c_uint, ctypes.c_uint,
                               ctypes.c_ulong, ctypes.c_int]
    xlib.XCloseDisplay.argtypes = [ctypes.c_void_p]
    connection = xlib.XOpenDisplay(display.encode())
    if not connection:
        raise OSError(f"no X display {display}")
    try:
        image = xlib.XGetImage(connection, xlib.XDefaultRootWindow(connection), x, y, width, height, ctypes.c_ulong(-1).value, ZPIXMAP)
        size = image.contents.bytes_per_line * image.contents.height
        rows = numpy.frombuffer(ctypes.string_at(image.contents.data, size), numpy.uint8)
        return rows.reshape(height, image.contents.bytes_per_line)[:, :4 * width].reshape(height, width, 4)[:, :, :3].copy()
    finally:
        xlib.XCloseDisplay(connection)


def draw_over(display, x, y, width, height):
    """Draws a white rectangle on the screen over all windows."""
    xlib = ctypes.CDLL("libX11.so.6")
    pointer, number = ctypes.c_void_p, ctypes.c_ulong
    xlib.XOpenDisplay.restype = pointer
    xlib.XDefaultRootWindow.restype = number
    xlib.XDefaultRootWindow.argtypes = [pointer]
    xlib.XCreateGC.restype = pointer
    xlib.XCreateGC.argtypes = [pointer, number, number, pointer]
    xlib.XSetSubwindowMode.argtypes = [pointer, pointer, ctypes.c_int]
    xlib.XSetForeground.argtypes = [pointer, pointer, number]
    xlib.XFillRectangle.argtypes = [pointer, number, pointer, ctypes.c_int, ctypes.c_int, ctypes.c_uint, ctypes.c_uint]
    xlib.XSync.argtypes = [pointer, ctypes.c_int]
    xlib.XCloseDisplay.argtypes = [pointer]
    connection = xlib.XOpenDisplay(display.encode())
    if not connection:
        raise OSError(f"no X display {display}")
    root = xlib.XDefaultRootWindow(connection)
    context = xlib.XCreateGC(connection, root, 0, None)
    include_inferiors = 1
    xlib.XSetSubwindowMode(connection, context, include_inferiors)
    xlib.XSetForeground(connection, context, 0xffffff)
    xlib.XFillRectangle(connection, root, context, x, y, width, height)
    xlib.XSync(connection, 0)
    xlib.XCloseDisplay(connection)
