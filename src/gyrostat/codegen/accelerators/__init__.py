"""Programs with one run in each work item of an accelerator: OpenCL or CUDA.

`source.py` has the text, `opencl.py` and `cuda.py` a device of either kind behind the interface of
`device.py`. Both are imported where they are used: they need a driver.
"""
