"""The figures and tables of Chen, Xu, Li, Sensors 18(6):1864, 2018, made again: what the paper says beside ours."""
